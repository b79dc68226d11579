//! Packets of steep rays and the triangles of a graph that they meet, with the bits of [`Mesh::intersect`].

use super::graph::Graph;
use super::mesh::{Mesh, Normals};
use crate::num::simd::{LANES, Lanes, Mask};
use glam::DVec3;

/// A vector in every lane, by its coordinates.
pub type Coordinates = [Lanes; 3];

/// Where the rays of a packet meet a mesh.
#[derive(Debug, Clone, Copy)]
pub struct PackedMeeting {
    /// Distances, in mm.
    pub t_mm: Lanes,
    /// The triangles.
    pub triangles: [u32; LANES],
    /// Weights of their corners.
    pub weights: [Lanes; 3],
}

/// Triangles of a cell that are asked: few have more.
const MOST_ASKED: usize = 16;

impl Mesh {
    /// Where rays towards +z, of unit directions, meet a mesh that is a graph, each within a triangle, of which one may be known to be
    /// near all of them; `None` where the scalar code has to tell.
    #[inline(always)]
    pub fn meet_all(&self, origin: Coordinates, direction: Coordinates, close: Option<u32>) -> Option<PackedMeeting> {
        // Start near the mesh.
        let (zero, endless) = (Lanes::splat(0.0), Lanes::splat(f64::INFINITY));
        let [dx, dy, dz] = direction;
        let ahead = ((Lanes::splat(self.first_z()) - origin[2]) / dz).max(zero);
        let near = [0, 1, 2].map(|k| origin[k] + direction[k] * ahead);
        let along_z = zero.lt(dz) & dx.abs().lt(dz) & dy.abs().lt(dz) & ahead.lt(endless);

        // Take the cells that the plane of the triangle leads to, or that in the middle of all heights.
        let graph = self.graph()?;
        let shear = [dx / dz, dy / dz, Lanes::splat(1.0) / dz];
        let (t, near_enough) = match close.filter(|id| (*id as usize) < self.triangles()) {
            Some(id) => (self.to_plane(id as usize, near, direction), Mask::splat(true)),
            None => graph.to_middle(near, direction, shear[2]),
        };
        if !(along_z & near_enough & graph.is_steep(direction)).all() {
            return None;
        }
        let cells = graph.cells(near, direction, t);

        // Ask its triangles, one of each lane at a time.
        let mut met = PackedMeeting { t_mm: zero, triangles: [0; LANES], weights: [zero; 3] };
        let mut found = Mask::splat(false);
        let mut corners = [[zero; 3]; 3];
        for k in 0..MOST_ASKED {
            let mut asked = met.triangles;
            let mut any = false;
            for lane in (0..LANES).filter(|lane| found.0[*lane] == 0) {
                let id = *cells[lane].get(k)?;
                (asked[lane], any) = (id, true);
                let places = self.own().triangles[id as usize].map(|corner| self.own().points_mm[corner as usize]);
                for (corner, place) in corners.iter_mut().zip(places) {
                    (corner[0].0[lane], corner[1].0[lane], corner[2].0[lane]) = (place.x, place.y, place.z);
                }
            }
            if !any {
                break;
            }
            let (t, weights, within) = within(near, shear, &corners);
            let fresh = within & zero.lt(t + ahead) & !found;
            met.t_mm = fresh.select(t + ahead, met.t_mm);
            for (to, weight) in met.weights.iter_mut().zip(weights) {
                *to = fresh.select(weight, *to);
            }
            for lane in (0..LANES).filter(|lane| fresh.0[*lane] != 0) {
                met.triangles[lane] = asked[lane];
            }
            found = found | fresh;
        }
        found.all().then_some(met)
    }

    /// How far rays are from the plane of a triangle.
    #[inline(always)]
    fn to_plane(&self, id: usize, origin: Coordinates, direction: Coordinates) -> Lanes {
        let point = self.own().points_mm[self.own().triangles[id][0] as usize].to_array();
        let normal = self.plane(id).to_array().map(Lanes::splat);
        let dot = |v: Coordinates| v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2];
        dot([0, 1, 2].map(|k| Lanes::splat(point[k]) - origin[k])) / dot(direction)
    }

    /// The unit normals that refract at a meeting.
    #[inline(always)]
    pub fn normals_at(&self, met: &PackedMeeting) -> Coordinates {
        let id = |lane: usize| met.triangles[lane] as usize;
        let normal = match self.normals() {
            Normals::Flat => gather(|lane| self.plane(id(lane))),
            Normals::Smooth => {
                let own = self.own();
                let [a, b, c] =
                    [0, 1, 2].map(|k| gather(|lane| own.point_normals[own.triangles[id(lane)][k] as usize]));
                let [wa, wb, wc] = met.weights;
                [0, 1, 2].map(|axis| a[axis] * wa + b[axis] * wb + c[axis] * wc)
            }
        };
        let [x, y, z] = normal;
        let inverse = Lanes::splat(1.0) / (x * x + y * y + z * z).sqrt();
        [x * inverse, y * inverse, z * inverse]
    }
}

/// The coordinates of a vector of each lane.
#[inline(always)]
fn gather(of: impl Fn(usize) -> DVec3) -> Coordinates {
    let each: [DVec3; LANES] = std::array::from_fn(of);
    [Lanes::of(|k| each[k].x), Lanes::of(|k| each[k].y), Lanes::of(|k| each[k].z)]
}

/// The watertight test of [`super::shear::ShearAxes`] of rays that run along z most: distances, weights of the corners, and whether
/// they pass within all three sides, on none of them.
#[inline(always)]
fn within(origin: Coordinates, shear: Coordinates, corners: &[Coordinates; 3]) -> (Lanes, [Lanes; 3], Mask) {
    let q = corners.map(|p| {
        let v = [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]];
        [v[0] - shear[0] * v[2], v[1] - shear[1] * v[2], shear[2] * v[2]]
    });
    let u = q[2][0] * q[1][1] - q[2][1] * q[1][0];
    let v = q[0][0] * q[2][1] - q[0][1] * q[2][0];
    let w = q[1][0] * q[0][1] - q[1][1] * q[0][0];
    let sum = u + v + w;
    let weights = [u / sum, v / sum, w / sum];
    let t = (u * q[0][2] + v * q[1][2] + w * q[2][2]) / sum;
    let zero = Lanes::splat(0.0);
    let inside = zero.lt(weights[0]) & zero.lt(weights[1]) & zero.lt(weights[2]);
    (t, weights, inside)
}

impl Graph {
    /// Whether rays are steeper than the triangles.
    #[inline(always)]
    fn is_steep(&self, [dx, dy, dz]: Coordinates) -> Mask {
        (self.steepness() * (dx * dx + dy * dy).sqrt()).lt(dz.abs())
    }

    /// How far rays are from the plane in the middle of the heights, given one over the z of their directions; and whether all heights
    /// are met in the cell there or beside it.
    #[inline(always)]
    fn to_middle(&self, origin: Coordinates, direction: Coordinates, inverse: Lanes) -> (Lanes, Mask) {
        let ([_, cells_per_mm], [level, half_height]) = self.frame();
        let spread = [0, 1].map(|k| (direction[k] * (inverse * half_height) * cells_per_mm[k]).abs());
        let most = Self::most_spread();
        ((level - origin[2]) * inverse, spread[0].lt(most) & spread[1].lt(most))
    }

    /// The triangles of the cells at so far along rays.
    #[inline(always)]
    fn cells(&self, origin: Coordinates, direction: Coordinates, t: Lanes) -> [&[u32]; LANES] {
        let ([low, cells_per_mm], _) = self.frame();
        let place = [0, 1].map(|k| (origin[k] + direction[k] * t - low[k]) * cells_per_mm[k]);
        std::array::from_fn(|lane| self.cell_of(place[0].0[lane], place[1].0[lane]))
    }
}
