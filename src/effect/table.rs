//! The one table of effects.

use super::effects::Effects;
use super::hook::Hook;
use super::id::EffectId;
use super::lens::Lens;

/// What the house knows of an effect.
#[derive(Debug, Clone, Copy)]
pub struct EffectRow {
    /// Which it is.
    pub id: EffectId,
    /// The effect without which it is nothing.
    pub needs: Option<EffectId>,
    /// Whether it acts by the glass of a prism, and does nothing without one.
    pub of_glass: bool,
    /// Where it takes hold.
    pub hook: Hook,
    /// What it is.
    pub what: &'static str,
    /// Where its formulas come from.
    pub source: &'static str,
    /// What it costs.
    pub cost: &'static str,
    /// Whether it is called for, and with a strength above 0.
    pub acts: fn(&Effects) -> bool,
    /// Takes its settings over from other effects.
    pub take: fn(&mut Effects, &Effects),
    /// How a bound of what it changes is found.
    pub bounding: Bounding,
}

/// How a bound of what an effect changes is found: see `system::bounds`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bounding {
    /// By its factors of the light over the picture.
    Factors,
    /// By how far its variants, or the instrument with it, see from what is seen without.
    Displacements,
    /// By the borders that it draws.
    Borders,
    /// By how far it spreads light.
    Spread,
    /// By the light that it adds.
    Added,
    /// Not at all, for this reason: it is always kept.
    Never(&'static str),
}

/// Every effect, in the order in which light meets them.
pub static TABLE: [EffectRow; 14] = [
    EffectRow {
        id: EffectId::Lamp,
        needs: None,
        of_glass: false,
        hook: Hook::Transport,
        what: "the board lit by a point lamp and evenly from all around",
        source: "inverse square law and Lambert's cosine law",
        cost: "one ray a pixel",
        acts: |effects| effects.lamp.is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.lamp = from.lamp,
        bounding: Bounding::Factors,
    },
    EffectRow {
        id: EffectId::Fresnel,
        needs: None,
        of_glass: true,
        hook: Hook::Transport,
        what: "what the surfaces of the glass reflect is missing behind it, polarised or not",
        source: "Fresnel's formulas (Born & Wolf, Principles of Optics, 1.5.2)",
        cost: "one ray a pixel",
        acts: |effects| effects.fresnel.is_some(),
        take: |to, from| to.fresnel = from.fresnel,
        bounding: Bounding::Factors,
    },
    EffectRow {
        id: EffectId::Coating,
        needs: Some(EffectId::Fresnel),
        of_glass: true,
        hook: Hook::Transport,
        what: "a single layer on every surface of the glass",
        source: "characteristic matrix (Macleod, Thin-Film Optical Filters, 2.6; Born & Wolf, 1.6.2)",
        cost: "nothing beyond `fresnel`, which it needs",
        acts: |effects| effects.fresnel.is_some() && effects.coating.is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.coating = from.coating,
        bounding: Bounding::Factors,
    },
    EffectRow {
        id: EffectId::Absorption,
        needs: None,
        of_glass: true,
        hook: Hook::Transport,
        what: "what the glass absorbs along the way of each ray",
        source: "Beer and Lambert's law",
        cost: "one ray a pixel",
        acts: |effects| effects.absorption.is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.absorption = from.absorption,
        bounding: Bounding::Factors,
    },
    EffectRow {
        id: EffectId::Ghosts,
        needs: Some(EffectId::Fresnel),
        of_glass: true,
        hook: Hook::Ray,
        what: "light that reaches the camera after reflections at the surfaces of the glass",
        source: "rays parted at every surface by Fresnel's formulas, without chance",
        cost: "samples x samples rays a pixel, each parted about 2 + bounces times; needs `fresnel`",
        acts: |effects| effects.fresnel.is_some() && effects.ghosts.is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.ghosts = from.ghosts,
        bounding: Bounding::Added,
    },
    EffectRow {
        id: EffectId::Dispersion,
        needs: None,
        of_glass: false,
        hook: Hook::Ray,
        what: "light of many wavelengths, each bent by its own index",
        source: "dispersion formulas of the makers and of articles, named with each glass in `optics::medium`",
        cost: "one picture for each wavelength",
        acts: |effects| effects.dispersion.as_ref().is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.dispersion = from.dispersion.clone(),
        bounding: Bounding::Displacements,
    },
    EffectRow {
        id: EffectId::Manufacture,
        needs: None,
        of_glass: true,
        hook: Hook::Instrument,
        what: "the prism out of place, of another thickness and index, its surfaces out of place and figure",
        source: "rigid motions; Zernike polynomials (ANSI Z80.28; Born & Wolf, Principles of Optics, 9.2.1)",
        cost: "no packets of rays where the back is moved against the front, or a figure is wrong",
        acts: |effects| effects.manufacture.as_ref().is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.manufacture = from.manufacture.clone(),
        bounding: Bounding::Displacements,
    },
    EffectRow {
        id: EffectId::Roughness,
        needs: None,
        of_glass: true,
        hook: Hook::Ray,
        what: "rough surfaces, which scatter light by their slopes",
        source: "geometric limit of scatter (Beckmann & Spizzichino, The Scattering of Electromagnetic Waves, 5.3)",
        cost: "one picture for each point of the slopes",
        acts: |effects| effects.roughness.is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.roughness = from.roughness,
        bounding: Bounding::Displacements,
    },
    EffectRow {
        id: EffectId::Clipping,
        needs: None,
        of_glass: false,
        hook: Hook::Instrument,
        what: "the rim of the prism, a ridge that is not sharp, and a stop before the lens, which rays do not pass",
        source: "geometry",
        cost: "pixels at a border of what passes are cut; no packets of rays",
        acts: |effects| effects.clipping.is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.clipping = from.clipping,
        bounding: Bounding::Borders,
    },
    EffectRow {
        id: EffectId::Telecentric,
        needs: None,
        of_glass: false,
        hook: Hook::Instrument,
        what: "pupils at infinity on both sides: everything is shown equally large, sharp at one distance",
        source: "Born & Wolf, Principles of Optics, 4.8.2 (telecentric stop), 4.5.1 (sine condition)",
        cost: "one picture for each point of the pupil",
        acts: |effects| effects.lens.telecentric().is_some(),
        take: |to, from| {
            if let Lens::Telecentric(_) = from.lens {
                to.lens = from.lens;
            }
        },
        bounding: Bounding::Never("it is another camera"),
    },
    EffectRow {
        id: EffectId::ThinLens,
        needs: None,
        of_glass: false,
        hook: Hook::Ray,
        what: "an aperture of finite size and shape, in focus at one distance",
        source: "thin lens equation (Born & Wolf, Principles of Optics, 4.4)",
        cost: "one picture for each point of the pupil",
        acts: |effects| effects.lens.thin().is_some_and(|e| !e.is_nothing()),
        take: |to, from| {
            if let Lens::Thin(_) = from.lens {
                to.lens = from.lens;
            }
        },
        bounding: Bounding::Displacements,
    },
    EffectRow {
        id: EffectId::Cos4,
        needs: None,
        of_glass: false,
        hook: Hook::Transport,
        what: "natural fall of illumination towards the rim of the picture",
        source: "cosine fourth law (Born & Wolf, Principles of Optics, 4.8.3)",
        cost: "one ray a pixel",
        acts: |effects| effects.cos4.is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.cos4 = from.cos4,
        bounding: Bounding::Factors,
    },
    EffectRow {
        id: EffectId::Diffraction,
        needs: None,
        of_glass: false,
        hook: Hook::Film,
        what: "the Airy pattern of a round aperture in place of a point, to 1e-3 of the contrast off the picture's border",
        source: "Born & Wolf, Principles of Optics, 8.5.2; Goodman, Introduction to Fourier Optics, 7.3",
        cost: "two cosine transforms of the picture, and up to 64 x 64 cells of each pixel on an edge",
        acts: |effects| effects.diffraction.is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.diffraction = from.diffraction,
        bounding: Bounding::Spread,
    },
    EffectRow {
        id: EffectId::Sensor,
        needs: None,
        of_glass: false,
        hook: Hook::Film,
        what: "from light to numbers: fill factor, colour filters, fixed pattern, shot and read noise, full well, ADC, gamma",
        source: "EMVA Standard 1288, linear model",
        cost: "some random numbers a pixel",
        acts: |effects| effects.sensor.is_some_and(|e| !e.is_nothing()),
        take: |to, from| to.sensor = from.sensor,
        bounding: Bounding::Never("a sensor is asked for as it is, and its noise has no bound"),
    },
];

impl EffectRow {
    /// Its key: its table in a scene file is `[effect.<key>]`.
    pub fn key(&self) -> &'static str {
        self.id.key()
    }
}

impl EffectId {
    /// What the house knows of it.
    pub fn row(self) -> &'static EffectRow {
        &TABLE[self as usize]
    }
}

impl Effects {
    /// The rows of [`TABLE`] that act.
    pub fn acting(&self) -> impl Iterator<Item = &'static EffectRow> {
        TABLE.iter().filter(|row| (row.acts)(self))
    }

    /// Of these effects, those of which `kept` says so, sampled as these, and none of them to be left out.
    #[must_use]
    pub fn only(&self, kept: impl Fn(&EffectRow) -> bool) -> Self {
        let mut only = Self { quadrature: self.quadrature, ..Self::default() };
        TABLE.iter().filter(|row| kept(row)).for_each(|row| (row.take)(&mut only, self));
        only
    }

    /// These effects without those that act by the glass of a prism.
    #[must_use]
    pub fn without_glass(&self) -> Self {
        Self { auto: self.auto, ..self.only(|row| !row.of_glass) }
    }

    /// Whether an effect with this hook acts.
    pub fn act_by(&self, hook: Hook) -> bool {
        self.acting().any(|row| row.hook == hook)
    }
}
