use super::bands::picture;
use super::centre_rays::CentreTracer;
use super::driver::{render, render_classed};
use super::film::{Class, Film, Outputs};
use super::plan::Plan;
use super::strips::{STRIP_ROWS, by_bands};
use crate::accuracy::{Accuracy, Sampling};
use crate::geom::Pose;
use crate::scene::{PrismSpec, Scene};
use crate::system::System;
use crate::{scene, system};
use glam::{DVec2, DVec3};

const BIPRISM: &str = "index = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545";
const BOARD: &str = "columns = 41\nrows = 41\nsquare_mm = 10.0";

pub(super) fn scene(width: usize, height: usize, prism: &str, board: &str) -> Scene {
    scene_from(width, height, "", prism, board)
}

/// [`scene`] with further keys of the camera.
fn scene_from(width: usize, height: usize, camera: &str, prism: &str, board: &str) -> Scene {
    let pitch_um = 10560.0 / width as f64;
    let text = format!(
        "name = \"test\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = {width}\nheight_px = {height}\n\
         pixel_pitch_um = {pitch_um}\n{camera}\n[prism]\n{prism}\n[board]\n{board}\n"
    );
    scene::parse(&text, "test", None).unwrap_or_else(|problem| panic!("{problem}\n{text}"))
}

pub(super) fn built(scene: &Scene, accuracy: Accuracy) -> System {
    system::build(scene).unwrap_or_else(|problem| panic!("{problem}")).with_accuracy(accuracy)
}

/// A wedge of air in glass, which reflects a part of the picture totally, and a board that a part of the rays never
/// meets: a scene file may not hold these, so they are made from one that is right.
fn dark_instrument(accuracy: Accuracy, scale: usize) -> System {
    let board = format!("{BOARD}\nposition_mm = [0.0, 0.0, 1000.0]");
    let mut scene = scene(90 * scale, 60 * scale, &format!("kind = \"flat\"\n{BIPRISM}"), &board);
    if let PrismSpec::Flat(flat) = &mut scene.prism {
        flat.body.index = 1.0;
        flat.body.outer_index = 1.48;
        flat.facet_angle_rad = Some(0.66);
        flat.thickness_mm = 40.0;
    }
    scene.board.world_from_board = Pose::new(DVec3::new(0.0, 0.0, 1000.0), DVec3::new(1.5, 0.0, 0.3));
    built(&scene, accuracy)
}

/// Instruments whose pictures are `scale` times as large as the smallest that show everything: prisms and boards that
/// take every way of the packets: planes, sheets of low, high and odd degree, poses, the ridge
/// off the centre and aslant, rays that miss, total reflection.
pub(super) fn instruments(accuracy: Accuracy, scale: usize) -> Vec<(String, System)> {
    let straight = format!("{BOARD}\nposition_mm = [0.0, 0.0, 1000.0]");
    let posed = format!("{BOARD}\nposition_mm = [3.0, -7.0, 800.0]\ntilt_deg = [5.0, -12.0, 20.0]");
    let flat = format!("kind = \"flat\"\n{BIPRISM}");
    let freeform = format!("kind = \"freeform\"\n{BIPRISM}");
    let prisms = [
        "kind = \"none\"".to_owned(),
        flat.clone(),
        format!("{flat}\nposition_mm = [0.4, 0.2, 1.0]\ntilt_deg = [1.0, 2.0, 7.0]"),
        freeform.clone(),
        format!("{freeform}\ndesign = {{ degree = 8 }}"),
        format!("{freeform}\ndesign = {{ degree = 10 }}"),
        format!("{freeform}\nposition_mm = [0.2, 0.1, 0.0]\ntilt_deg = [0.5, 0.3, 1.0]"),
        // Odd in y.
        "kind = \"polynomial\"\nindex = 1.48\n\
         front = { centre_mm = [6, 0.5], scale_mm = [6, 6], domain_mm = [[-1, 14], [-8, 8]],\
         terms = [[0, 0, 79.5], [1, 0, 0.9], [0, 1, 0.05], [2, 1, 0.02], [0, 3, 0.01]] }\n\
         back = { centre_mm = [6, 0], scale_mm = [6, 6], domain_mm = [[-1, 14], [-8, 8]],\
         terms = [[0, 0, 87], [1, 1, 0.01]] }"
            .to_owned(),
    ];
    let boards = [straight, posed];
    let pairs = prisms.iter().flat_map(|prism| boards.iter().map(move |board| (prism, board)));
    let built = |((prism, board), (width, height)): ((&String, &String), _)| {
        let (width, height) = (scale * width, scale * height);
        let system = built(&scene(width, height, prism, board), accuracy);
        (format!("{prism}\n{board}\n{width} x {height}"), system)
    };
    let sizes = [(200, 112), (131, 75), (66, 37)].into_iter().cycle();
    let mut all: Vec<_> = pairs.zip(sizes).map(built).collect();
    all.push(("dark".to_owned(), dark_instrument(accuracy, scale)));

    // Cameras with principal point, rotation and distortion.
    for (prism, board) in [(&prisms[0], &boards[1]), (&flat, &boards[0]), (&prisms[6], &boards[1])] {
        let [width, height] = [131 * scale, 75 * scale];
        let camera = format!(
            "principal_point_px = [{:?}, {:?}]\nrotation_deg = [0.2, -0.3, 1.0]\ndistortion = [-0.3, 0.4, 0.002, -0.001, 0]",
            0.52 * width as f64,
            0.49 * height as f64
        );
        let system = self::built(&scene_from(width, height, &camera, prism, board), accuracy);
        all.push((format!("{camera}\n{prism}\n{board}\n{width} x {height}"), system));
    }
    all
}

fn film(plan: &Plan) -> Film {
    picture(plan, Outputs { truth: true }, &())
}

/// The ground truth of a film that has it.
fn truth(film: &Film) -> (&[Class], &[[f32; 2]]) {
    let expected = "the ground truth is asked for";
    (film.class.as_ref().expect(expected).data(), film.board_mm.as_ref().expect(expected).data())
}

/// Every bit of a film.
fn bits(film: &Film) -> (Vec<u32>, Vec<Class>, Vec<[u32; 2]>) {
    let radiance = film.radiance.data().iter().map(|v| v.to_bits()).collect();
    let (class, board_mm) = truth(film);
    (radiance, class.to_vec(), board_mm.iter().map(|p| p.map(f32::to_bits)).collect())
}

#[test]
fn packets_have_the_bits_of_single_rays() {
    let mut classes = Vec::new();
    for (name, system) in instruments(Accuracy::exact(), 1) {
        let by = |packets| Plan {
            centre_tracer: CentreTracer::new(&system, packets),
            ..Plan::by(&system, Sampling::Packets, false, 1)
        };
        let (single, packets) = (film(&by(false)), film(&by(true)));
        assert!(bits(&single) == bits(&packets), "{name}");
        assert_eq!(single.counts, packets.counts, "{name}");
        classes.extend(truth(&single).0.iter().map(|c| *c as u8));
    }
    classes.sort_unstable();
    classes.dedup();
    assert_eq!(classes, [0, 1, 2, 3, 5], "the scenes above no longer show every class");
}

/// f64 positions too, not only what f32 keeps of them.
#[test]
fn packets_see_the_very_positions_of_single_rays() {
    use super::centre_rays::{Run, trace_scalar};
    use glam::DVec2;
    for (name, system) in instruments(Accuracy::exact(), 1) {
        let [width, height] = system.camera().size_px();
        let centre_tracer = CentreTracer::new(&system, true);
        for j in (0..height).step_by(7) {
            let start = DVec2::new(0.25, j as f64 + 0.375);
            let (mut x, mut y, mut class) = (vec![0.0; width], vec![0.0; width], vec![Class::Left; width]);
            centre_tracer.trace(start, Run { x_mm: &mut x, y_mm: &mut y, class: &mut class });
            for i in 0..width {
                let (seen, own) = trace_scalar(&system, start + DVec2::new(i as f64, 0.0));
                let equal = (x[i].to_bits(), y[i].to_bits(), class[i]) == (seen.x.to_bits(), seen.y.to_bits(), own);
                assert!(equal, "({i}, {j}): {} {} {seen}\n{name}", x[i], y[i]);
            }
        }
    }
}

/// Strips one below the other are the picture, and of the same work.
#[test]
fn strips_make_the_picture() {
    let mut subdivided = 0;
    for accuracy in [Accuracy::draft(), Accuracy::exact()] {
        for (name, system) in instruments(accuracy, 2) {
            let whole = render(&system, &());
            let (mut radiance, mut class, mut board_mm, mut heights) = (vec![], vec![], vec![], vec![]);
            let (counts, account) = by_bands(&Plan::new(&system), 2, &(), &mut |strip| {
                heights.push(strip.radiance.height());
                radiance.extend_from_slice(strip.radiance.data());
                class.extend_from_slice(strip.class.expect("strips have it").data());
                board_mm.extend_from_slice(strip.board_mm.expect("strips have it").data());
            });
            assert!(radiance == whole.radiance.data() && (&class[..], &board_mm[..]) == truth(&whole), "{name}");
            assert_eq!((counts, account), (whole.counts, whole.account), "{name}");
            let (last, others) = heights.split_last().expect("a picture has rows");
            assert!(others.iter().all(|h| *h == 2 * STRIP_ROWS) && *last <= 2 * STRIP_ROWS, "{heights:?}");
            subdivided += others.len();
        }
    }
    assert!(subdivided > 10, "the scenes above are no longer higher than a strip");
}

#[test]
fn a_mirrored_half_has_the_bits_of_a_rendered_one() {
    for (accuracy, scale) in [(Accuracy::exact(), 1), (Accuracy::standard(), 3), (Accuracy::draft(), 3)] {
        let mut mirrored = 0;
        for (name, system) in instruments(accuracy, scale) {
            if system.is_mirror_symmetric() {
                mirrored += 1;
                let by = |mirrored| film(&Plan::by(&system, accuracy.sampling, mirrored, 1));
                assert!(bits(&by(false)) == bits(&by(true)), "{:?}\n{name}", accuracy.level);
            }
        }
        assert!(mirrored >= 3, "the scenes above are no longer their own mirror images");
    }
}

/// Patches, traced regions and the mirrored half cover every pixel once.
#[test]
fn the_map_covers_the_sensor_once() {
    let mut mapped = 0;
    for (name, system) in instruments(Accuracy::standard(), 3) {
        let plan = Plan::new(&system);
        let [width, height] = system.camera().size_px();
        let mut times = vec![0; width * height];
        let seam = plan.seams.iter().map(|seam| &seam.region);
        for region in plan.patches.iter().map(|p| &p.region).chain(seam).chain(&plan.traced) {
            for (i, j) in region.rows.clone().flat_map(|j| region.columns.clone().map(move |i| (i, j))) {
                times[j * width + i] += 1;
                if plan.mirrored {
                    times[j * width + width - 1 - i] += 1;
                }
            }
        }
        assert!(times.iter().all(|n| *n == 1), "{name}");
        mapped += usize::from(!plan.patches.is_empty());
    }
    assert!(mapped >= 12, "only {mapped} instruments have a patch of a map");
}

/// A sample of what is traced is of that, however little it is.
#[test]
fn samples_of_the_traced_part_are_traced() {
    let mut some = 0;
    for (name, system) in instruments(Accuracy::standard(), 3) {
        let plan = Plan::new(&system);
        let traced = plan.pixel_work().traced > 0;
        some += usize::from(traced && !plan.patches.is_empty());
        for share in [0.0, 0.37, 0.999_999] {
            let piece = plan.sample_traced(DVec2::splat(share), 2);
            assert!(piece.map(|piece| !piece.mapped && piece.pixels > 0) == traced.then_some(true), "{name}");
        }
    }
    assert!(some > 0, "no instrument has a map and traced pixels beside it");
}

/// The map against every pixel traced: classes, positions and radiance, wherever it is used.
#[test]
fn the_certified_map_shows_what_is_traced() {
    let exact = instruments(Accuracy::exact(), 3);
    for ((name, exact), (_, mapped)) in exact.iter().zip(instruments(Accuracy::standard(), 3)) {
        let plan = Plan::new(&mapped);
        assert!(plan.patches.iter().all(|patch| patch.error_px <= 1e-8), "{name}");
        let (traced, found) = (render(exact, &()), film(&plan));
        assert!(traced.class == found.class, "{name}");
        for (a, b) in truth(&traced).1.iter().flatten().zip(truth(&found).1.iter().flatten()) {
            // f32 keeps 24 bits, and 1e-8 px are at most 2e-8 mm on these boards.
            assert!((a - b).abs() <= 2.0 * f32::EPSILON * a.abs() + 2e-8, "{a} {b}\n{name}");
        }
        for (k, (a, b)) in traced.radiance.data().iter().zip(found.radiance.data()).enumerate() {
            // 1e-8 px move a line by that and f32 rounds; but the derivatives come from differences of neighbours on the
            // one hand, which third derivatives of up to 1e-5 px on these coarse sensors make wrong by a sixth of that.
            assert!((a - b).abs() <= 2e-6, "{k}: {a} {b}\n{name}");
        }
    }
}

#[test]
fn any_number_of_threads_makes_the_same_picture() {
    for (name, system) in instruments(Accuracy::exact(), 1) {
        let by = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
            pool.install(|| render(&system, &()))
        };
        let (one, three) = (by(1), by(3));
        assert!(bits(&one) == bits(&three) && one.counts == three.counts, "{name}");
    }
}

/// So they do where points of a pupil stand for the parts around them, whose blur runs in strips and rows.
#[test]
fn any_number_of_threads_fills_the_pupil_alike() {
    use crate::effect::{Effects, Lens, Quadrature, ThinLens, thin_lens::Aperture};
    let lens = Lens::Thin(ThinLens::new(2.0, 500.0, Aperture::Circle, 35.0));
    let quadrature = Quadrature { points: 4, fill: true, ..Quadrature::default() };
    let board = format!("{BOARD}\nposition_mm = [0.0, 0.0, 1000.0]");
    let own = built(&scene(250, 110, "kind = \"none\"", &board), Accuracy::draft());
    let by = |threads: usize, fill: bool| {
        let system =
            own.with_effects(&Effects { lens, quadrature: Quadrature { fill, ..quadrature }, ..Effects::default() });
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        bits(&pool.install(|| render(&system, &())))
    };
    let one = by(1, true);
    assert!(one == by(3, true) && one == by(2, true));
    assert!(one != by(1, false), "nothing is filled");
}

/// Each channel is the mean by its own shares.
#[test]
fn colours_are_the_passes_by_their_shares() {
    use crate::effect::{Effects, Lens, ThinLens, Variant, Variants, thin_lens::Aperture};
    use crate::render::accumulate::VariantSets;
    use glam::DVec2;
    // Aside, so that the picture is not made its own mirror image.
    let scene = scene(66, 38, "kind = \"none\"", &format!("{BOARD}\nposition_mm = [1.0, 0.0, 1000.0]"));
    let lens = ThinLens::new(2.0, 500.0, Aperture::Circle, 35.0);
    let effects = Effects { lens: Lens::Thin(lens), ..Effects::default() };
    let system = built(&scene, Accuracy::exact()).with_effects(&effects);
    let variant = |x: f64, grey, colour| Variant {
        pupil: DVec2::new(x, 0.0),
        slopes: [DVec2::ZERO; 2],
        wave: None,
        grey,
        colour: Some(colour),
    };
    let variants = [variant(-3.0, 0.25, [1.0, 0.0, 0.5]), variant(3.0, 0.75, [0.0, 1.0, 0.5])];
    let summed = crate::render::accumulate::mean(
        &system,
        &VariantSets { set: &|_| Variants::new(variants.to_vec(), None), fill: None },
        Outputs { truth: false },
        &(),
    );
    let [a, b] = variants.map(|variant| film(&Plan::new(&system.variant(&variant))).radiance);
    assert!(a != b);
    let colour = summed.colour.expect("every variant has colours");
    for (k, [red, green, blue]) in colour.data().iter().enumerate() {
        let (a, b) = (a.data()[k], b.data()[k]);
        assert_eq!([*red, *green], [a, b]);
        assert_eq!(*blue, (0.5 * f64::from(a) + 0.5 * f64::from(b)) as f32);
        assert_eq!(summed.radiance.data()[k], (0.25 * f64::from(a) + 0.75 * f64::from(b)) as f32);
    }
}

/// The polynomial of the gains against the gain of every traced pixel.
#[test]
fn the_map_of_gains_gains_what_is_traced() {
    use crate::effect::{Cos4, Effects, Lamp};
    let lamp = Lamp::new(DVec3::new(-400.0, 300.0, 200.0), 0.9, DVec3::new(0.0, 0.0, 1000.0), DVec3::Z);
    let effects = Effects { cos4: Some(Cos4 { exponent: 4.0 }), lamp: Some(lamp), ..Effects::default() };
    let mut fitted = 0;
    let exact = instruments(Accuracy::exact(), 2);
    for ((name, exact), (_, mapped)) in exact.into_iter().zip(instruments(Accuracy::standard(), 2)) {
        let [exact, mapped] = [exact, mapped].map(|system| system.with_effects(&effects));
        let plan = Plan::new(&mapped);
        fitted += plan.patches.iter().filter(|patch| patch.throughput.is_some()).count();
        let (traced, found) = (render(&exact, &()), film(&plan));
        for (k, (a, b)) in traced.radiance.data().iter().zip(found.radiance.data()).enumerate() {
            // As without gains, which are at most 1.5 here.
            assert!((a - b).abs() <= 3e-6, "{k}: {a} {b}\n{name}");
        }
    }
    assert!(fitted >= 12, "only {fitted} patches have a polynomial of gains");
}

/// The instrument of a shipped case.
fn case(name: &str) -> System {
    let path = format!("{}/scenes/cases/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let scene = scene::load(path.as_ref()).unwrap_or_else(|problem| panic!("{problem}"));
    system::build(&scene).unwrap_or_else(|problem| panic!("{problem}"))
}

/// Of pictures that are their own mirror images one half is added: the sum is that of the whole pictures.
#[test]
fn the_sum_of_mirrored_pictures_is_that_of_whole_ones() {
    let system = case("effect_dispersion");
    let mean = render(&system, &());
    let mut sum = vec![0.0f64; mean.radiance.data().len()];
    for variant in system.effects().variants(0).iter() {
        let one = system.variant(&variant);
        let plan = Plan::new(&one);
        assert!(plan.mirrored);
        let picture = film(&plan);
        sum.iter_mut().zip(picture.radiance.data()).for_each(|(sum, v)| *sum += variant.grey * f64::from(*v));
    }
    assert!(mean.radiance.data().iter().zip(&sum).all(|(mean, sum)| mean.to_bits() == (*sum as f32).to_bits()));
}

/// A picture without its truth has the same light, and the same classes.
#[test]
fn classes_are_those_of_the_truth() {
    let system = case("effect_dispersion");
    let (whole, classed) = (render(&system, &()), render_classed(&system, &()));
    assert!(whole.class.is_some() && whole.board_mm.is_some() && classed.board_mm.is_none());
    assert!(whole.class == classed.class && whole.radiance == classed.radiance && whole.counts == classed.counts);
}
