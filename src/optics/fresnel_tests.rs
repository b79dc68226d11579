//! Fresnel's formulas against closed forms and conservation of power.

use super::*;
use Polarisation::{P, S};
use proptest::prelude::*;

#[test]
fn along_the_normal_reflection_is_the_textbook_one() {
    for (n_in, n_out) in [(1.0, 1.48), (1.5168, 1.0), (1.0, 2.4), (1.333, 1.0)] {
        let r = (n_in - n_out) / (n_in + n_out);
        for polarisation in [S, P] {
            let s = Interface::bare(n_in, n_out).shares(polarisation, 1.0);
            // Four roundings of each share.
            assert!((s.reflected - r * r).abs() < 1e-15 && (s.transmitted - (1.0 - r * r)).abs() < 1e-15);
        }
    }
}

#[test]
fn at_brewsters_angle_p_is_not_reflected() {
    let (n_in, n_out): (f64, f64) = (1.0, 1.5);
    let cos = n_in / (n_in * n_in + n_out * n_out).sqrt();
    let interface = Interface::bare(n_in, n_out);
    assert!(interface.shares(P, cos).reflected < 1e-30);
    // For s the closed form there: r = (n_in^2 - n_out^2) / (n_in^2 + n_out^2).
    let r: f64 = (1.0 - 2.25) / 3.25;
    assert!((interface.shares(S, cos).reflected - r * r).abs() < 1e-15);
}

/// Born & Wolf, 1.5.2, Eqs. 20 and 21, in sines and tangents of the angles.
#[test]
fn oblique_reflection_is_the_sine_and_tangent_law() {
    for degrees in [5.0, 22.5, 45.0, 70.0, 89.0f64] {
        let (i, n) = (degrees.to_radians(), 1.62);
        let t = libm::asin(libm::sin(i) / n);
        let r_s = -libm::sin(i - t) / libm::sin(i + t);
        let r_p = libm::tan(i - t) / libm::tan(i + t);
        let interface = Interface::bare(1.0, n);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-14;
        assert!(close(interface.shares(S, libm::cos(i)).reflected, r_s * r_s));
        assert!(close(interface.shares(P, libm::cos(i)).reflected, r_p * r_p));
        assert!(close(interface.amplitudes(S, libm::cos(i), interface.cos_out(libm::cos(i))).reflected.re, r_s));
        assert!(close(interface.amplitudes(P, libm::cos(i), interface.cos_out(libm::cos(i))).reflected.re, r_p));
    }
}

#[test]
fn the_quarter_wave_layer_of_the_geometric_mean_reflects_nothing() {
    let (n_out, wavelength_nm) = (1.5168f64, 550.0);
    let matched = Layer::quarter_wave(n_out.sqrt(), wavelength_nm);
    let interface = |layer| Interface { n_in: 1.0, n_out, layer: Some((layer, wavelength_nm)) };
    assert!(interface(matched).unpolarised(1.0).reflected < 1e-30);
    // MgF2: R = ((n_in n_out - n^2) / (n_in n_out + n^2))^2.
    let index = 1.38f64;
    let r = (n_out - index * index) / (n_out + index * index);
    let mgf2 = interface(Layer::quarter_wave(index, wavelength_nm));
    assert!((mgf2.unpolarised(1.0).reflected - r * r).abs() < 1e-15);
    // Half a wave is as if absent.
    let half = interface(Layer { index, thickness_nm: 0.5 * wavelength_nm / index });
    let bare = Interface::bare(1.0, n_out).unpolarised(1.0).reflected;
    assert!((half.unpolarised(1.0).reflected - bare).abs() < 1e-15);
}

/// Airy's sum over the reflections inside the layer, independent of the matrix (Born & Wolf, 1.6.4, Eq. 60).
#[test]
fn a_layer_is_the_sum_of_its_inner_reflections() {
    let (layer, wavelength_nm) = (Layer { index: 1.38, thickness_nm: 143.0 }, 486.1);
    for cos_in in [1.0, 0.9, 0.5, 0.1f64] {
        for polarisation in [S, P] {
            let whole = Interface { n_in: 1.0, n_out: 1.7, layer: Some((layer, wavelength_nm)) };
            let cos_layer = (1.0f64 - (1.0 - cos_in * cos_in) / (1.38 * 1.38)).sqrt();
            let amplitude = |interface: Interface, cos: f64| {
                interface.amplitudes(polarisation, cos, interface.cos_out(cos)).reflected
            };
            let r12 = amplitude(Interface::bare(1.0, 1.38), cos_in);
            let r23 = amplitude(Interface::bare(1.38, 1.7), cos_layer);
            let turn = -2.0 * std::f64::consts::TAU * 1.38 * 143.0 * cos_layer / wavelength_nm;
            let turn = Complex::new(libm::cos(turn), libm::sin(turn));
            let sum = (r12 + r23 * turn) / (r12 * r23 * turn + 1.0);
            assert!((amplitude(whole, cos_in) - sum).norm_sqr() < 1e-28);
            assert!((whole.shares(polarisation, cos_in).reflected - sum.norm_sqr()).abs() < 1e-14);
        }
    }
}

#[test]
fn no_thickness_is_no_layer_to_the_last_bit() {
    for k in 0..=1000 {
        let cos_in = f64::from(k) / 1000.0;
        for (n_in, n_out) in [(1.0, 1.48), (1.48, 1.0)] {
            let layer = Layer { index: 1.38, thickness_nm: 0.0 };
            let coated = Interface { n_in, n_out, layer: Some((layer, 550.0)) };
            for polarisation in [S, P] {
                let bare = Interface::bare(n_in, n_out);
                assert_eq!(coated.shares(polarisation, cos_in), bare.shares(polarisation, cos_in));
                let cos_out = bare.cos_out(cos_in);
                let [a, b] = [coated, bare].map(|i| i.amplitudes(polarisation, cos_in, cos_out));
                assert_eq!(a, b);
            }
        }
    }
}

/// Light tunnels through a thin gap: at 45 degrees between two prisms of 1.5 with an air gap (Born & Wolf, 1.6.4).
#[test]
fn light_tunnels_through_a_thin_gap_only() {
    let gap = |thickness_nm| {
        let layer = Some((Layer { index: 1.0, thickness_nm }, 500.0));
        Interface { n_in: 1.5, n_out: 1.5, layer }.shares(S, 0.5f64.sqrt())
    };
    assert!(gap(0.0).transmitted == 1.0);
    assert!(gap(50.0).transmitted > 0.5 && gap(1000.0).transmitted < 1e-3);
    assert_eq!(gap(1e9), Shares { reflected: 1.0, transmitted: 0.0 });
    // T = 1 / (1 + F sinh^2), F = ((a^2 + k^2) / (2 a k))^2 with a = n cos, k = sqrt(n^2 sin^2 - 1).
    let (a2, k2) = (1.125, 0.125f64);
    let sinh = libm::sinh(std::f64::consts::TAU * 200.0 / 500.0 * k2.sqrt());
    let expected = 1.0 / (1.0 + (a2 + k2) * (a2 + k2) / (4.0 * a2 * k2) * sinh * sinh);
    assert!((gap(200.0).transmitted - expected).abs() < 1e-14);
}

/// Phases of total reflection (Born & Wolf, 1.5.4, Eq. 60), and under a layer Airy's sum over its inner reflections.
#[test]
fn total_reflection_turns_the_phase_by_its_closed_form() {
    let (n, cos_in) = (1.5f64, 0.5f64);
    let sine2 = 0.75;
    let root = (sine2 - 1.0 / (n * n)).sqrt();
    let bare = Interface::bare(n, 1.0);
    for (polarisation, tangent) in [(S, root / cos_in), (P, n * n * root / cos_in)] {
        let r = bare.amplitudes(polarisation, cos_in, None).reflected;
        let angle = 2.0 * libm::atan(tangent);
        assert!((r - Complex::new(libm::cos(angle), libm::sin(angle))).norm_sqr() < 1e-28, "{r}");
    }
    let (layer, wavelength_nm) = (Layer { index: 1.38, thickness_nm: 143.0 }, 486.1);
    let coated = Interface { n_in: n, n_out: 1.0, layer: Some((layer, wavelength_nm)) };
    let cos_layer = (1.0 - sine2 * n * n / (1.38 * 1.38)).sqrt();
    let turn = -2.0 * std::f64::consts::TAU * 1.38 * 143.0 * cos_layer / wavelength_nm;
    let turn = Complex::new(libm::cos(turn), libm::sin(turn));
    for polarisation in [S, P] {
        let r12 = Interface::bare(n, 1.38).amplitudes(polarisation, cos_in, Some(cos_layer)).reflected;
        let r23 = Interface::bare(1.38, 1.0).amplitudes(polarisation, cos_layer, None).reflected;
        let sum = (r12 + r23 * turn) / (r12 * r23 * turn + 1.0);
        assert!((coated.amplitudes(polarisation, cos_in, None).reflected - sum).norm_sqr() < 1e-28);
    }
}

#[test]
fn absorption_undoes_itself() {
    let per_mm = absorption_per_mm(0.98, 10.0);
    assert!((left_after(per_mm, 10.0) - 0.98).abs() < 1e-15);
    assert!((left_after(per_mm, 25.0) - libm::pow(0.98, 2.5)).abs() < 1e-15);
    assert_eq!(left_after(0.0, 1e9), 1.0);
    assert_eq!(absorption_per_mm(1.0, 10.0), 0.0);
}

/// Cosines from 0 to 1, a third of them within 1e-16 ..= 1e-3 of grazing or of the critical angle of `n_in` / `n_out`.
fn cosine(n_in: f64, n_out: f64) -> impl Strategy<Value = f64> {
    (0.0..=1.0f64, 0..6u8, -16.0..-3.0f64).prop_map(move |(cos, kind, exponent)| {
        let small = libm::pow(10.0, exponent);
        let critical = (1.0 - (n_out / n_in) * (n_out / n_in)).max(0.0).sqrt();
        match kind {
            0 => small,
            1 => (critical * (1.0 + small)).min(1.0),
            2 => critical * (1.0 - small),
            _ => cos,
        }
    })
}

fn media() -> impl Strategy<Value = (f64, f64, f64)> {
    (1.0..4.0f64, 1.0..4.0f64, 0..5u8).prop_flat_map(|(n_in, n_out, kind)| {
        let n_out = if kind == 0 { n_in } else { n_out };
        (Just(n_in), Just(n_out), cosine(n_in, n_out))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// Nothing is lost: both shares come from formulas of their own.
    #[test]
    fn shares_add_up_to_one(
        (n_in, n_out, cos_in) in media(),
        index in 1.0..4.0f64,
        thickness_nm in prop_oneof![Just(0.0), 0.0..2000.0f64],
        coated in any::<bool>(),
    ) {
        let layer = coated.then_some((Layer { index, thickness_nm }, 550.0));
        let interface = Interface { n_in, n_out, layer };
        for polarisation in [S, P] {
            let shares = interface.shares(polarisation, cos_in);
            prop_assert!((shares.reflected + shares.transmitted - 1.0).abs() < 1e-14, "{shares:?}");
            prop_assert!(shares.reflected >= 0.0 && shares.transmitted >= 0.0);
            let amplitudes = interface.amplitudes(polarisation, cos_in, interface.cos_out(cos_in));
            prop_assert!((amplitudes.reflected.norm_sqr() - shares.reflected).abs() < 1e-14);
            prop_assert!((amplitudes.transmitted.norm_sqr() - shares.transmitted).abs() < 1e-14);
        }
    }

    /// The same surface from behind lets as much through (reciprocity).
    #[test]
    fn both_ways_let_as_much_through((n_in, n_out, cos_in) in media(), index in 1.0..3.0f64) {
        let layer = Some((Layer { index, thickness_nm: 100.0 }, 550.0));
        let forth = Interface { n_in, n_out, layer };
        let back = Interface { n_in: n_out, n_out: n_in, layer };
        // Towards the critical angle or grazing one way is ill-conditioned: its cosine has lost the digits.
        if let Some(cos_out) = forth.cos_out(cos_in).filter(|cos_out| cos_out.min(cos_in) > 1e-3) {
            for polarisation in [S, P] {
                let (a, b) = (forth.shares(polarisation, cos_in), back.shares(polarisation, cos_out));
                prop_assert!((a.transmitted - b.transmitted).abs() < 1e-9, "{a:?} {b:?}");
            }
        }
    }
}
