//! A field as it is shown while it is still being computed.

use glam::Vec3;

use crate::gpu::coarse::Coarse;

/// Rounds of passing values on: so many elements a value reaches at most.
const ROUNDS: usize = 12;

/// Fills a field in over the triangles of a mesh, or, of a large one, over its coarse triangles; there each vertex
/// without a value takes that of the vertex that stands for it.
pub(super) fn fill_unknown(field: &mut [Vec3], mut known: Vec<bool>, triangles: &[[u32; 3]], coarse: Option<&Coarse>) {
    let Some(coarse) = coarse else {
        pass_on(field, known, triangles);
        return;
    };
    let unknown: Vec<usize> = (0..field.len()).filter(|&vertex| !known[vertex]).collect();
    // One value in a cell is enough.
    for vertex in 0..field.len() {
        let representative = coarse.representatives[vertex] as usize;
        if known[vertex] && !known[representative] {
            (field[representative], known[representative]) = (field[vertex], true);
        }
    }
    pass_on(field, known, &coarse.indices);
    for vertex in unknown {
        field[vertex] = field[coarse.representatives[vertex] as usize];
    }
}

/// Gives each vertex that has no value yet the mean of its neighbours' values, those nearest to known ones first, so
/// that a picture which is half done is whole, if blurred, and not spotted. For the screen alone.
fn pass_on(field: &mut [Vec3], mut known: Vec<bool>, triangles: &[[u32; 3]]) {
    let mut open: Vec<[usize; 3]> = triangles.iter().map(|corners| corners.map(|corner| corner as usize)).collect();
    let mut sums = vec![(Vec3::ZERO, 0.0_f32); field.len()];
    for _ in 0..ROUNDS {
        open.retain(|corners| corners.iter().any(|&corner| !known[corner]));
        let mut reached = Vec::new();
        for corners in &open {
            let mut values = (Vec3::ZERO, 0.0);
            for &corner in corners.iter().filter(|&&corner| known[corner]) {
                values = (values.0 + field[corner], values.1 + 1.0);
            }
            if values.1 > 0.0 {
                for &corner in corners.iter().filter(|&&corner| !known[corner]) {
                    let sum = &mut sums[corner];
                    *sum = (sum.0 + values.0, sum.1 + values.1);
                    reached.push(corner);
                }
            }
        }
        if reached.is_empty() {
            return;
        }
        for vertex in reached {
            field[vertex] = sums[vertex].0 / sums[vertex].1;
            known[vertex] = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_passed_on_from_neighbour_to_neighbour_and_known_ones_stay() {
        // A strip of triangles over the vertices 0 to 5; 0 and 5 are known.
        let triangles: Vec<[u32; 3]> = (0..4).map(|first| [first, first + 1, first + 2]).collect();
        let mut field = vec![Vec3::ZERO; 6];
        (field[0], field[5]) = (Vec3::ONE, Vec3::splat(3.0));
        fill_unknown(&mut field, vec![true, false, false, false, false, true], &triangles, None);
        assert_eq!((field[0], field[5]), (Vec3::ONE, Vec3::splat(3.0)));
        assert_eq!((field[1], field[2]), (Vec3::ONE, Vec3::ONE));
        assert_eq!((field[3], field[4]), (Vec3::splat(3.0), Vec3::splat(3.0)));
    }

    #[test]
    fn in_a_large_mesh_one_value_is_enough_for_a_cell_and_cells_pass_theirs_on() {
        // Three cells of two vertices each; the second vertex of the first cell alone is known.
        let coarse = Coarse { indices: vec![[0, 2, 4]], representatives: vec![0, 0, 2, 2, 4, 4], draws: Vec::new() };
        let mut field = vec![Vec3::ZERO; 6];
        field[1] = Vec3::splat(2.0);
        fill_unknown(&mut field, vec![false, true, false, false, false, false], &[], Some(&coarse));
        assert_eq!(field, [Vec3::splat(2.0); 6]);
    }

    #[test]
    fn a_field_of_which_nothing_is_known_stays_dark() {
        let mut field = vec![Vec3::ZERO; 3];
        fill_unknown(&mut field, vec![false; 3], &[[0, 1, 2]], None);
        assert_eq!(field, [Vec3::ZERO; 3]);
    }
}
