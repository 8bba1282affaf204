//! Tasks `stratified` and `qmc`: sample points that are spread better than by chance.

use glam::Vec2;

use super::probe::{Check, Failure, Problem, Trial, call, quiet, written};
use crate::check::chi_square::random_points;

const STRATIFIED: &str = "stratified_point";
const SEQUENCE: &str = "low_discrepancy_point";

/// Squares, primes, and others.
const COUNTS: [u32; 14] = [4, 16, 100, 256, 1, 2, 3, 6, 7, 8, 31, 60, 97, 257];

/// The cell of a point: where jitter (0, 0) and almost (1, 1) lead.
fn cell(function: fn(u32, u32, Vec2) -> Vec2, index: u32, count: u32) -> Result<(Vec2, Vec2), Problem> {
    let at = |jitter: Vec2| {
        let input = format_args!("point {index} of {count}, jitter {jitter}");
        call(STRATIFIED, input, || function(index, count, jitter))
    };
    Ok((at(Vec2::ZERO)?, at(Vec2::splat(1.0 - f32::EPSILON))?))
}

pub(super) fn stratified(trial: &Trial) -> Check {
    let function = trial.functions.stratified_point;
    written(trial, STRATIFIED, &[(0, 9), (4, 9), (8, 9)], |functions, (index, count)| {
        (functions.stratified_point)(index, count, Vec2::new(0.3, 0.6))
    })?;
    let fails = |test, measured: String, expected: &str, fallback| {
        Err(Failure::new(STRATIFIED, test, measured, expected).fallback(fallback).into())
    };
    for count in COUNTS {
        let mut cells = Vec::new();
        for index in 0..count {
            let (low, high) = cell(function, index, count)?;
            if low.min(high).min_element() < 0.0 || low.max(high).max_element() >= 1.0 {
                let measured = format!("point {index} of {count} lies between {low} and {high}");
                return fails("range", measured, "in [0, 1)²", "points lie outside of the square: count the cells");
            }
            let (area, share) = ((high - low).element_product().abs(), 1.0 / count as f32);
            if (area - share).abs() > 1e-3 * share {
                let measured = format!("cell {index} of {count} has area {area:.5}");
                return fails("area of the cells", measured, &format!("{share:.5} = 1/{count}"), NO_HINT);
            }
            cells.push((low.min(high), low.max(high)));
        }
        for (index, jitter) in (0..count).zip(random_points(trial.seed, count)) {
            let (low, high) = cell(function, index, count)?;
            let found = call(STRATIFIED, format_args!("jitter {jitter}"), || function(index, count, jitter))?;
            let expected = low + jitter * (high - low);
            if !found.abs_diff_eq(expected, 1e-5) {
                let measured = format!("{found} for jitter {jitter} of the cell from {low} to {high}");
                return fails(
                    "jitter",
                    measured,
                    &format!("{expected}"),
                    "the jitter moves a point evenly over its cell",
                );
            }
        }
        if let Some((a, b)) = overlap(&cells) {
            let measured = format!("cells {a} and {b} of {count} overlap");
            return fails("cells apart", measured, "cells that tile the square", NO_HINT);
        }
        let side = (count as f32).sqrt();
        let is_square = |&(low, high): &(Vec2, Vec2)| (high - low).abs_diff_eq(Vec2::splat(1.0 / side), 1e-4);
        if side.fract() == 0.0 && !cells.iter().all(is_square) {
            let measured = format!("the first of {count} cells runs from {} to {}", cells[0].0, cells[0].1);
            let hint = "for a square number the cells are the squares of a grid, not strips";
            return fails("squares of a grid", measured, &format!("squares of side 1/{side}"), hint);
        }
    }
    Ok(())
}

const NO_HINT: &str = "each of `count` cells of equal area gets one point, also where count is no square number";

fn overlap(cells: &[(Vec2, Vec2)]) -> Option<(usize, usize)> {
    let inner = |(low, high): (Vec2, Vec2)| (low + 1e-4 * (high - low), high - 1e-4 * (high - low));
    let apart = |a: (Vec2, Vec2), b: (Vec2, Vec2)| a.1.cmple(b.0).any() || b.1.cmple(a.0).any();
    (0..cells.len()).find_map(|a| {
        let meets = |b: &usize| !apart(inner(cells[a]), inner(cells[*b]));
        (a + 1..cells.len()).find(meets).map(|b| (a, b))
    })
}

pub(super) fn diagnose_stratified(trial: &Trial, failure: &Failure) -> Option<String> {
    if failure.test == "squares of a grid" {
        return None;
    }
    let function = trial.functions.stratified_point;
    let moved = |index: u32| {
        let at = |jitter: f32| quiet(|| function(index, 16, Vec2::splat(jitter)));
        at(0.0).zip(at(0.01)).map(|(start, end)| 100.0 * (end - start))
    };
    let is_unscaled = (0..16).all(|index| moved(index).is_some_and(|step| step.abs_diff_eq(Vec2::ONE, 1e-2)));
    let cells = |count: u32| -> Option<Vec<(Vec2, Vec2)>> {
        let corner = |index, jitter| quiet(|| function(index, count, jitter));
        (0..count).map(|index| Some((corner(index, Vec2::ZERO)?, corner(index, Vec2::splat(0.999))?))).collect()
    };
    let (square, odd) = (cells(16)?, cells(7)?);
    let all = |cells: &[(Vec2, Vec2)], test: fn(Vec2, Vec2) -> bool| cells.iter().all(|(low, high)| test(*low, *high));
    let is_right = |cells: &[(Vec2, Vec2)]| {
        let share = 1.0 / cells.len() as f32;
        let has_area = |(low, high): &(Vec2, Vec2)| ((*high - *low).element_product() - share).abs() < 0.02 * share;
        cells.iter().all(has_area) && overlap(cells).is_none()
    };
    let hint = if all(&square, |low, high| low.abs_diff_eq(high, 1e-6)) {
        "the jitter is not used: every point sits at the same place of its cell"
    } else if all(&square, |low, high| (high - low).min_element() > 0.99 && low.min_element() < 1e-6) {
        "the point is not moved into its cell: every cell is the whole square"
    } else if square.iter().all(|cell| cell.0.abs_diff_eq(square[0].0, 1e-6)) {
        "all points fall into the first cell: an integer division gives 0; divide as numbers with a fraction"
    } else if square.iter().all(|cell| cell.0.y == square[0].0.y) || square.iter().all(|cell| cell.0.x == square[0].0.x)
    {
        "all points fall into one row or column: an integer division gives 0; divide as numbers with a fraction"
    } else if square.iter().all(|(low, _)| (low.x - low.y).abs() < 1e-6) {
        "the cells lie on the diagonal: row and column of the grid must differ, quotient and remainder"
    } else if is_unscaled {
        "the jitter is not scaled to the cell: it must be divided by the number of rows and columns"
    } else if is_right(&square) && !is_right(&odd) {
        "square numbers work, others do not: the last row holds fewer cells, which must be wider and as high as their share"
    } else {
        return None;
    };
    Some(String::from(hint))
}

/// How many points, and how many times better than random ones they must be spread at least: some two thirds of what
/// the sequences of Halton (bases 2 and 3, 3 and 5), Sobol and Roberts (R2) reach. Random points reach 1.9 by chance.
const PREFIXES: [(u32, f32); 6] = [(50, 1.2), (64, 1.2), (250, 2.4), (256, 2.2), (500, 3.0), (1000, 4.0)];

/// Squared star discrepancy in the mean square, by Warnock's formula (1972).
fn squared_discrepancy(points: &[Vec2]) -> f64 {
    let count = points.len() as f64;
    let inverse = |point: &Vec2| 1.0 - point.as_dvec2();
    let single: f64 = points.iter().map(|point| (1.0 - point.as_dvec2() * point.as_dvec2()).element_product()).sum();
    let both = |a: &Vec2, b: &Vec2| inverse(a).min(inverse(b)).element_product();
    let double: f64 = points.iter().map(|a| points.iter().map(|b| both(a, b)).sum::<f64>()).sum();
    1.0 / 9.0 - single / (2.0 * count) + double / (count * count)
}

/// How many times better than `count` random points are in the mean: their squared discrepancy is (1/4 - 1/9) / count.
fn gain(points: &[Vec2]) -> f64 {
    let random = (0.25 - 1.0 / 9.0) / points.len() as f64;
    (random / squared_discrepancy(points).max(1e-12)).sqrt()
}

pub(super) fn qmc(trial: &Trial) -> Check {
    let function = trial.functions.low_discrepancy_point;
    written(trial, SEQUENCE, &[1, 2, 3, 10], |functions, index| (functions.low_discrepancy_point)(index))?;
    let mut points = Vec::new();
    for index in 0..1000 {
        let point = call(SEQUENCE, format_args!("point {index}"), || function(index))?;
        if point.min_element() < 0.0 || point.max_element() >= 1.0 {
            let measured = format!("point {index} is {point}");
            return Err(Failure::new(SEQUENCE, "range", measured, "in [0, 1)²").into());
        }
        points.push(point);
    }
    for (count, least) in PREFIXES {
        let gain = gain(&points[..count as usize]);
        if gain < f64::from(least) {
            let measured = format!("the first {count} points are spread {gain:.2} times as well as random ones");
            let expected = format!("at least {least} times (mean square star discrepancy)");
            return Err(Failure::new(SEQUENCE, "spread of the first points", measured, &expected)
                .fallback("the points are not spread evenly from the start: the digits must be mirrored at the point")
                .into());
        }
    }
    let last = call(SEQUENCE, "the last point", || function(u32::MAX))?;
    if last.min_element() < 0.0 || last.max_element() >= 1.0 {
        let failure = Failure::new(SEQUENCE, "range", format!("point {} is {last}", u32::MAX), "in [0, 1)²");
        return Err(failure.hint("rounding takes a point to 1: keep it below").into());
    }
    Ok(())
}

pub(super) fn diagnose_qmc(trial: &Trial, failure: &Failure) -> Option<String> {
    let function = trial.functions.low_discrepancy_point;
    let points: Vec<Vec2> = (0..1000).filter_map(|index| quiet(|| function(index))).collect();
    if points.len() < 1000 {
        return None;
    }
    let all = |test: &dyn Fn(Vec2) -> bool| points.iter().all(|point| test(*point));
    let is_even = |value: fn(&Vec2) -> f32| {
        let mut cells = [0_u32; 10];
        for point in &points {
            cells[(value(point).clamp(0.0, 0.999) * 10.0) as usize] += 1;
        }
        cells.iter().all(|count| count.abs_diff(100) < 5)
    };
    let outside = points.iter().filter(|point| point.max_element() >= 1.0).count();
    let hint = if failure.test == "range" && outside > 0 {
        if all(&|point| point.fract() == point) || outside < 3 {
            "rounding takes a point to 1: keep it below"
        } else {
            "the first digit counts a whole: its place value is 1/base, the next 1/base²"
        }
    } else if all(&|point| (point.x - point.y).abs() < 1e-6) {
        "both coordinates are the same: take another base, 2 and 3"
    } else if all(&|point| point.x == points[1].x) || all(&|point| point.y == points[1].y) {
        "one coordinate never changes: an integer division gives 0?"
    } else if points[..100].iter().all(|point| point.max_element() < 0.2) {
        "the first points crowd in a corner: index/count is no sequence, the digits must be mirrored at the point"
    } else if is_even(|point| point.x) && is_even(|point| point.y) {
        "each coordinate is spread evenly, both together are not: the bases must have no common divisor (2 and 3)"
    } else if (0.6..1.6).contains(&gain(&points)) {
        "the points are no better than random ones"
    } else if is_even(|point| point.x) != is_even(|point| point.y) {
        "one coordinate is spread evenly, the other is not: look at its digits and its base"
    } else {
        return None;
    };
    Some(String::from(hint))
}
