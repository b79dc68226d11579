use super::*;
use crate::surface::normals::corner_normals;

/// A dome over a square of 20 mm, 80 mm away.
fn dome(x: f64, y: f64) -> (f64, DVec3) {
    (80.0 + 0.01 * (x * x + 0.5 * y * y), DVec3::new(-0.02 * x, -0.01 * y, 1.0).normalize())
}

fn mesh(cells: usize, normals: Normals) -> Mesh {
    let square = Rect { min: DVec2::splat(-10.0), max: DVec2::splat(10.0) };
    Mesh::new(Triangles::over(square, cells, dome), normals)
}

/// The stacks of rays hold as many nodes as the tree is deep.
#[test]
fn the_depth_of_the_hierarchy_is_known() {
    let mut own = Triangles { points_mm: Vec::new(), point_normals: Vec::new(), triangles: Vec::new() };
    for line in include_str!("../../tests/fixtures/meshes/over_one_another.obj").lines() {
        let numbers: Vec<f64> = line.split(' ').skip(1).flat_map(str::parse).collect();
        match (line.as_bytes()[0], &numbers[..]) {
            (b'v', &[x, y, z]) => own.points_mm.push(DVec3::new(x, y, z)),
            (b'f', &[a, b, c, ref more @ ..]) => {
                let (mut last, all) = (b, std::iter::once(&c).chain(more));
                for next in all {
                    own.triangles.push([a, last, *next].map(|k| k as u32 - 1));
                    last = *next;
                }
            }
            _ => assert_eq!(line.as_bytes()[0], b'#'),
        }
    }
    assert!(own.triangles.len() > 150);
    own.point_normals = vec![DVec3::Z; own.points_mm.len()];
    let mesh = Mesh::new(own, Normals::Flat);
    let hierarchy = mesh.hierarchy();
    assert!(hierarchy.depth(0) < hierarchy.max_depth, "{} {}", hierarchy.depth(0), hierarchy.max_depth);
}

fn towards(target: DVec3) -> Ray {
    let origin = DVec3::new(0.7, -0.3, 0.0);
    Ray { origin, direction: (target - origin).normalize() }
}

/// Rays at corners and at the middles of edges, where a test that is not watertight loses one in six.
#[test]
fn no_ray_slips_between_triangles() {
    let mesh = mesh(60, Normals::Flat);
    let mut aimed = 0;
    for id in 0..mesh.triangles() {
        let [a, b, c] = mesh.corners(id);
        for target in [a, b, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (a + c), (a + b + c) / 3.0] {
            // The rim has triangles on one side only.
            if target.x.abs().max(target.y.abs()) < 9.99 {
                aimed += 1;
                let met = mesh.intersect(&towards(target)).expect("the mesh is closed");
                // Edges of 1/3 mm on a dome of curvature 0.02/mm lie within 3e-4 mm of it.
                assert!((met.t_mm - (target - towards(target).origin).length()).abs() < 1e-3);
            }
        }
    }
    assert!(aimed > 40_000 && mesh.graph.is_some());
    assert_eq!(mesh.intersect(&towards(DVec3::new(10.5, 0.0, 81.0))), Err(Fate::Missed));
}

#[test]
fn finer_meshes_tend_to_the_surface() {
    let error = |cells: usize, normals: Normals| {
        let mesh = mesh(cells, normals);
        (0..500).fold((0.0f64, 0.0f64), |(position, slope), k| {
            let (x, y) = (9.0 * libm::sin(1.3 * k as f64), 9.0 * libm::cos(0.7 * k as f64));
            let (z, normal) = dome(x, y);
            let ray = towards(DVec3::new(x, y, z));
            let met = mesh.intersect(&ray).expect("aimed inside");
            let off = (met.t_mm - (DVec3::new(x, y, z) - ray.origin).length()).abs();
            (position.max(off), slope.max((met.normal * met.normal.z.signum() - normal).length()))
        })
    };
    // Cells of h = 20/cells mm: z is off by at most curvature h^2/8 a direction, a facet's slope by curvature h/2 or so,
    // an interpolated slope by its third derivatives only, which a dome hardly has.
    for cells in [20, 40, 80] {
        let h = 20.0 / cells as f64;
        let (position, flat) = error(cells, Normals::Flat);
        let (_, smooth) = error(cells, Normals::Smooth);
        assert!(position < 1.1 * (0.02 + 0.01) * h * h / 8.0 && position > 0.1 * 0.02 * h * h / 8.0, "{position}");
        assert!(flat < 0.02 * h && flat > 0.002 * h && smooth < 0.02 * 0.02 * h, "{flat} {smooth}");
    }
}

#[test]
fn the_turn_of_the_normal_is_its_derivative() {
    let mesh = mesh(7, Normals::Smooth);
    let target = DVec3::new(3.1, -2.2, dome(3.1, -2.2).0);
    let ray = towards(target);
    let met = mesh.intersect(&ray).expect("aimed inside");
    let (point, plane) = (ray.at(met.t_mm), mesh.tangent(&met));
    let step = plane.cross(DVec3::X).normalize() * 1e-5;
    let beside = Ray { origin: ray.origin, direction: (point + step - ray.origin).normalize() };
    let there = mesh.intersect(&beside).expect("it is near");
    assert_eq!(there.part, met.part);
    let turn = mesh.normal_change(&met, point, met.normal, step);
    // The second order of a turn of 2e-7 is below 1e-13.
    assert!((there.normal - met.normal - turn).length() < 1e-12 && turn.length() > 1e-8, "{turn}");
    let flipped = mesh.normal_change(&met, point, -met.normal, step);
    assert_eq!(flipped, -turn);
}

#[test]
fn corner_normals_tend_to_those_of_the_surface() {
    let square = Rect { min: DVec2::splat(-10.0), max: DVec2::splat(10.0) };
    let worst = |cells: usize| {
        let t = Triangles::over(square, cells, dome);
        let own = corner_normals(&t.points_mm, &t.triangles).expect("it is a graph");
        let inside = |p: &DVec3| p.x.abs().max(p.y.abs()) < 9.0;
        let pairs = own.iter().zip(&t.point_normals).zip(&t.points_mm).filter(|(_, p)| inside(p));
        pairs.fold(0.0f64, |worst, ((a, b), _)| worst.max((*a - *b).length()))
    };
    // Second order: half the cells, a quarter of the error.
    let (coarse, fine) = (worst(20), worst(40));
    assert!(fine < 0.3 * coarse && coarse < 0.02, "{coarse} {fine}");
    assert_eq!(corner_normals(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], &[[0, 1, 2]]), Err(3));
    assert_eq!(corner_normals(&[DVec3::ZERO, DVec3::X, DVec3::Z], &[[0, 1, 2]]), Err(0));
}
