//! Refractive indices by wavelength: published dispersion formulas of glasses, plastics and crystals.
//!
//! Indices are relative to air at about 20 C, as catalogues give them, but for that of water, which is 0.0003 more, relative
//! to vacuum. The formulas are those of the sources named in each
//! row; their coefficients were taken from the refractiveindex.info database (M. N. Polyanskiy, Scientific Data 11 (2024)
//! 94, public domain) and, for Zeonex, from the article itself.

/// Wavelengths of the Fraunhofer lines F, d and C, in nm (ISO 7944).
pub const F_NM: f64 = 486.1327;
/// The yellow helium line, at which catalogues give n_d.
pub const D_NM: f64 = 587.5618;
/// The red hydrogen line.
pub const C_NM: f64 = 656.2725;

/// A material with a published dispersion formula.
#[derive(Debug, PartialEq)]
pub struct Material {
    /// The name used in scenes.
    pub name: &'static str,
    /// n^2 by wavelength.
    formula: Formula,
    /// Wavelengths for which the source gives the formula, in nm.
    pub range_nm: [f64; 2],
    /// Where the formula comes from.
    pub source: &'static str,
}

/// n^2 as a function of the wavelength l in um.
#[derive(Debug, PartialEq)]
enum Formula {
    /// n^2 = 1 + sum B l^2 / (l^2 - C), by [B, C] with C in um^2 (Sellmeier 1871).
    Sellmeier(&'static [[f64; 2]]),
    /// n^2 = sum c l^p, by (c, p) with even p (Laurent series, "Schott's old formula").
    Series(&'static [(f64, i32)]),
}

/// A wavelength for which a material's source says nothing.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the index of {name} is known from {} to {} nm, not at {wavelength_nm} nm", range_nm[0], range_nm[1])]
pub struct OutOfRange {
    /// The material.
    pub name: &'static str,
    /// What was requested.
    pub wavelength_nm: f64,
    /// What is known.
    pub range_nm: [f64; 2],
}

const SCHOTT: &str = "SCHOTT optical glass catalogue, 2017-01-20";
const SULTANOVA: &str = "Sultanova, Kasarova & Nikolov, Acta Phys. Pol. A 116 (2009) 585, indices measured to 0.001; the \
                         dispersion n_F - n_C of the fit is 4 % above theirs";

/// A row of the table whose formula is Sellmeier's.
const fn sellmeier(
    name: &'static str,
    terms: &'static [[f64; 2]],
    range_nm: [f64; 2],
    source: &'static str,
) -> Material {
    Material { name, formula: Formula::Sellmeier(terms), range_nm, source }
}

/// Every material that a scene may name.
pub static MATERIALS: [Material; 18] = [
    sellmeier(
        "N-BK7",
        &[[1.039_612_12, 0.006_000_698_67], [0.231_792_344, 0.020_017_914_4], [1.010_469_45, 103.560_653]],
        [300.0, 2500.0],
        SCHOTT,
    ),
    sellmeier(
        "N-FK51A",
        &[[0.971_247_817, 0.004_723_019_95], [0.216_901_417, 0.015_357_561_2], [0.904_651_666, 168.681_33]],
        [290.0, 2500.0],
        SCHOTT,
    ),
    sellmeier(
        "N-K5",
        &[[1.085_118_33, 0.006_610_995_03], [0.199_562_005, 0.024_110_866], [0.930_511_663, 111.982_777]],
        [310.0, 2500.0],
        SCHOTT,
    ),
    sellmeier(
        "N-BAK4",
        &[[1.288_346_42, 0.007_799_806_26], [0.132_817_724, 0.031_563_117_7], [0.945_395_373, 105.965_875]],
        [334.0, 2500.0],
        SCHOTT,
    ),
    sellmeier(
        "N-LAK22",
        &[[1.142_297_81, 0.005_857_785_94], [0.535_138_441, 0.019_854_614_7], [1.040_883_85, 100.834_017]],
        [310.0, 2500.0],
        SCHOTT,
    ),
    sellmeier(
        "F2",
        &[[1.345_333_59, 0.009_977_438_71], [0.209_073_176, 0.047_045_076_7], [0.937_357_162, 111.886_764]],
        [320.0, 2500.0],
        SCHOTT,
    ),
    sellmeier(
        "N-F2",
        &[[1.397_570_37, 0.009_959_061_43], [0.159_201_403, 0.054_693_175_2], [1.268_654_3, 119.248_346]],
        [365.0, 2500.0],
        SCHOTT,
    ),
    sellmeier(
        "N-SF6",
        &[[1.779_317_63, 0.013_371_418_2], [0.338_149_866, 0.061_753_362_1], [2.087_344_74, 174.017_59]],
        [370.0, 2500.0],
        SCHOTT,
    ),
    sellmeier(
        "N-SF11",
        &[[1.737_596_95, 0.013_188_707], [0.313_747_346, 0.062_306_814_2], [1.898_781_01, 155.236_29]],
        [370.0, 2500.0],
        SCHOTT,
    ),
    sellmeier(
        "N-SF57",
        &[[1.875_438_31, 0.014_174_951_8], [0.373_757_49, 0.064_050_992_7], [2.300_017_97, 177.389_795]],
        [370.0, 2500.0],
        SCHOTT,
    ),
    // These three sources give the square roots of the poles.
    sellmeier(
        "fused-silica",
        &[
            [0.696_166_3, 0.068_404_3 * 0.068_404_3],
            [0.407_942_6, 0.116_241_4 * 0.116_241_4],
            [0.897_479_4, 9.896_161 * 9.896_161],
        ],
        [210.0, 3710.0],
        "Malitson, J. Opt. Soc. Am. 55 (1965) 1205",
    ),
    sellmeier(
        "CaF2",
        &[
            [0.567_588_8, 0.050_263_605 * 0.050_263_605],
            [0.471_091_4, 0.100_390_9 * 0.100_390_9],
            [3.848_472_3, 34.649_04 * 34.649_04],
        ],
        [230.0, 9700.0],
        "Malitson, Appl. Opt. 2 (1963) 1103",
    ),
    sellmeier(
        "MgF2",
        &[
            [0.487_551_08, 0.043_384_08 * 0.043_384_08],
            [0.398_750_31, 0.094_614_42 * 0.094_614_42],
            [2.312_035_3, 23.793_604 * 23.793_604],
        ],
        [200.0, 7000.0],
        "Dodge, Appl. Opt. 23 (1984) 1980, ordinary ray of the crystal",
    ),
    sellmeier(
        "water",
        &[
            [0.568_402_756_5, 0.005_101_829_712],
            [0.172_617_739_1, 0.018_211_539_36],
            [0.020_861_895_78, 0.026_207_222_93],
            [0.113_074_868_8, 10.697_927_21],
        ],
        [182.0, 1129.0],
        "Daimon & Masumura, Appl. Opt. 46 (2007) 3811, at 20 C",
    ),
    Material {
        name: "PMMA",
        formula: Formula::Series(&[
            (2.1778, 0),
            (6.1209e-3, 2),
            (-1.5004e-3, 4),
            (2.3678e-2, -2),
            (-4.2137e-3, -4),
            (7.3417e-4, -6),
            (-4.5042e-5, -8),
        ]),
        range_nm: [420.0, 1620.0],
        source: "Beadie et al., Appl. Opt. 54 (2015) F139, one batch, to 0.0002",
    },
    sellmeier("polycarbonate", &[[1.4182, 0.021_304]], [436.8, 1052.0], SULTANOVA),
    sellmeier("polystyrene", &[[1.4435, 0.020_216]], [436.8, 1052.0], SULTANOVA),
    Material {
        name: "Zeonex-E48R",
        formula: Formula::Series(&[
            (2.482_396, 0),
            (-6.959_91e-2, 2),
            (-1.597_726e-1, -2),
            (7.383_333e-2, -4),
            (-1.398_485e-2, -6),
            (9.728_455e-4, -8),
        ]),
        range_nm: [435.8, 1052.0],
        source: "Kasarova et al., Opt. Mater. 29 (2007) 1481, indices measured to 0.001; the dispersion n_F - n_C of the \
                 fit is 8 % above the maker's",
    },
];

/// The material of that name.
pub fn named(name: &str) -> Option<&'static Material> {
    MATERIALS.iter().find(|m| m.name == name)
}

impl Material {
    /// The refractive index at a wavelength in vacuum, in nm.
    ///
    /// # Errors
    /// [`OutOfRange`] where the source says nothing.
    pub fn index(&self, wavelength_nm: f64) -> Result<f64, OutOfRange> {
        let [first, last] = self.range_nm;
        if wavelength_nm >= first && wavelength_nm <= last {
            Ok(self.formula.index(wavelength_nm / 1000.0))
        } else {
            Err(OutOfRange { name: self.name, wavelength_nm, range_nm: self.range_nm })
        }
    }

    /// n_d, the index at 587.56 nm; every range of the table holds it.
    pub fn n_d(&self) -> f64 {
        self.formula.index(D_NM / 1000.0)
    }

    /// The wavelengths, in nm, at which the index is `index`, to within `tolerance`: the middle of the first such stretch
    /// of 1 nm steps over the range of the source that lies between 300 and 1100 nm. `None` when there is none.
    pub fn wavelength_nm_of(&self, index: f64, tolerance: f64) -> Option<f64> {
        let [first, last] = self.range_nm;
        let fits = |nm: &f64| (self.formula.index(nm / 1000.0) - index).abs() <= tolerance;
        let steps = (first.max(300.0).ceil() as u32..=last.min(1100.0) as u32).map(f64::from);
        let stretch: Vec<f64> = steps.skip_while(|nm| !fits(nm)).take_while(fits).collect();
        Some(0.5 * (stretch.first()? + stretch.last()?))
    }
}

impl Formula {
    fn index(&self, um: f64) -> f64 {
        let square = um * um;
        let n2 = match self {
            Self::Sellmeier(terms) => {
                1.0 + terms.iter().map(|[strength, pole]| strength * square / (square - pole)).sum::<f64>()
            }
            Self::Series(terms) => terms.iter().map(|&(c, power)| c * even_power(square, power)).sum(),
        };
        n2.sqrt()
    }
}

/// l^p for even p, given l^2.
fn even_power(square: f64, power: i32) -> f64 {
    let factor = if power < 0 { 1.0 / square } else { square };
    (0..power.abs() / 2).fold(1.0, |p, _| p * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n_d and V_d as the makers' data sheets and the sources print them; half a unit of the last digit printed, or what
    /// the source says of its own accuracy.
    #[test]
    fn index_and_abbe_number_are_those_of_the_catalogue() {
        for (name, n_d, abbe, index_digit, abbe_digit) in [
            ("N-BK7", 1.5168, 64.17, 5e-6, 5e-3),
            ("N-FK51A", 1.48656, 84.47, 5e-6, 5e-3),
            ("N-K5", 1.52249, 59.48, 5e-6, 5e-3),
            ("N-BAK4", 1.56883, 55.98, 5e-6, 5e-3),
            ("N-LAK22", 1.65113, 55.89, 5e-6, 5e-3),
            ("F2", 1.62004, 36.37, 5e-6, 5e-3),
            ("N-F2", 1.62005, 36.43, 5e-6, 5e-3),
            ("N-SF6", 1.80518, 25.36, 5e-6, 5e-3),
            ("N-SF11", 1.78472, 25.68, 5e-6, 5e-3),
            ("N-SF57", 1.84666, 23.78, 5e-6, 5e-3),
            // Malitson's table, and 67.8 in every catalogue.
            ("fused-silica", 1.458_46, 67.8, 5e-6, 0.05),
            // Schott's lithotec CaF2 at 22 C, where Malitson measured at 24 C: dn/dT is -1e-5/K.
            ("CaF2", 1.43385, 95.1, 2e-5, 0.3),
            ("MgF2", 1.37774, 106.22, 5e-6, 5e-3),
            // IAPWS: n_D = 1.33299 at 589.3 nm and 20 C; +0.00006 for the two lines' distance, relative to vacuum.
            ("water", 1.3334, 55.8, 1e-4, 0.1),
            // Sultanova et al. (2009), measured to 0.001.
            ("PMMA", 1.491, 59.2, 2e-3, 0.5),
            ("polycarbonate", 1.585, 29.1, 1e-3, 0.05 * 29.1),
            ("polystyrene", 1.592, 30.5, 1e-3, 0.05 * 30.5),
            // Data sheet of the maker: 1.531, 56.
            ("Zeonex-E48R", 1.531, 56.0, 1e-3, 0.085 * 56.0),
        ] {
            let m = named(name).expect("in the table");
            // The last digit of a sum of rounded terms: a hair of slack.
            assert!((m.n_d() - n_d).abs() <= index_digit * 1.001, "{name}: n_d = {}", m.n_d());
            // The Abbe number V_d = (n_d - 1) / (n_F - n_C).
            let [f, c] = [F_NM, C_NM].map(|nm| m.index(nm).expect("visible"));
            let found = (m.n_d() - 1.0) / (f - c);
            assert!((found - abbe).abs() <= abbe_digit * 1.001, "{name}: V_d = {found}");
            assert_eq!(m.index(D_NM), Ok(m.n_d()));
        }
    }

    /// The slip that the design paper makes: n_d stands for the index at 486 nm.
    #[test]
    fn the_index_of_bk7_at_486_nm_is_not_its_n_d() {
        let bk7 = named("N-BK7").expect("in the table");
        // The data sheet's n_F and n_C.
        assert!((bk7.index(F_NM).expect("visible") - 1.52238).abs() < 5e-6);
        assert!((bk7.index(C_NM).expect("visible") - 1.51432).abs() < 5e-6);
        let belongs = bk7.wavelength_nm_of(1.5168, 5e-5).expect("it is n_d");
        assert!((belongs - D_NM).abs() < 2.0, "{belongs}");
        assert_eq!(bk7.wavelength_nm_of(1.6, 1e-3), None);
    }

    /// Sultanova et al. (2009), Table 1: eight wavelengths, printed to 0.001 and measured to 0.001.
    #[test]
    fn plastics_keep_to_the_measured_indices() {
        let nm = [436.8, 486.1, 587.6, 632.8, 703.0, 833.0, 879.0, 1052.0];
        for (name, measured) in [
            ("polycarbonate", [1.612, 1.599, 1.585, 1.580, 1.575, 1.569, 1.568, 1.565]),
            ("polystyrene", [1.617, 1.606, 1.592, 1.587, 1.582, 1.577, 1.576, 1.572]),
        ] {
            for (nm, n) in nm.into_iter().zip(measured) {
                let fitted = named(name).expect("in the table").index(nm).expect("in its range");
                assert!((fitted - n).abs() <= 1.5e-3, "{name} at {nm}: {fitted} against {n}");
            }
        }
    }

    #[test]
    fn index_falls_with_the_wavelength() {
        for m in &MATERIALS {
            let [first, last] = m.range_nm;
            let indices: Vec<f64> = (0..=200)
                .map(|k| m.index(first + (last.min(1100.0) - first) * f64::from(k) / 200.0).expect("in its range"))
                .collect();
            assert!(indices.windows(2).all(|pair| pair[1] < pair[0]), "{}", m.name);
        }
    }

    #[test]
    fn wavelength_out_of_range_is_named() {
        let pc = named("polycarbonate").expect("in the table");
        let told = pc.index(400.0).expect_err("below the range").to_string();
        assert_eq!(told, "the index of polycarbonate is known from 436.8 to 1052 nm, not at 400 nm");
        assert!(pc.index(f64::NAN).is_err());
    }
}
