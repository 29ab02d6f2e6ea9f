//! Routes arcs along the grid.

use super::drawn::{Drawn, HALF, Spot};
use std::collections::BTreeMap;

/// The part of an arc between two layers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// The arc.
    pub(super) arc: usize,
    /// Its upper end: index, column, and whether it is an element.
    pub(super) upper: (usize, i32, bool),
    pub(super) lower: (usize, i32, bool),
    /// The row below its start.
    pub(super) bottom: i32,
}

/// The horizontal offsets at which lines leave an element.
fn ports(count: usize) -> Vec<i32> {
    let step = if count <= 3 { 2 } else { 1 };
    let middle = i32::try_from(count.saturating_sub(1)).unwrap_or(0) * step / 2;
    (0..count)
        .map(|at| (i32::try_from(at).unwrap_or(0) * step - middle).clamp(-HALF, HALF))
        .collect()
}

/// The columns of the pieces' ends on one side.
fn columns(
    pieces: &[Piece],
    own: impl Fn(&Piece) -> (usize, i32, bool),
    other: impl Fn(&Piece) -> i32,
) -> Vec<i32> {
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (at, piece) in pieces.iter().enumerate() {
        groups.entry(own(piece).0).or_default().push(at);
    }
    let mut found = vec![0; pieces.len()];
    for mut group in groups.into_values() {
        group.sort_by_key(|&at| other(&pieces[at]));
        for (&at, offset) in group.iter().zip(ports(group.len())) {
            let (_, x, is_element) = own(&pieces[at]);
            found[at] = if is_element { x + offset } else { x };
        }
    }
    found
}

/// Routes the pieces in a channel that begins in row `top`. Returns the number of tracks, and each arc's corners.
pub(super) fn channel(pieces: &[Piece], top: i32) -> (i32, Vec<(usize, Vec<Spot>)>) {
    let begins = columns(pieces, |piece| piece.upper, |piece| piece.lower.1);
    let mut ends = columns(pieces, |piece| piece.lower, |piece| piece.upper.1);
    // Two lines in the same column, one up and one down, would overlap.
    for at in 0..pieces.len() {
        let (_, x, is_element) = pieces[at].lower;
        let is_taken = |column: i32| {
            let others = (0..pieces.len()).filter(|&other| other != at);
            others.into_iter().any(|other| begins[other] == column || ends[other] == column)
        };
        if is_element && begins[at] != ends[at] && is_taken(ends[at]) {
            let near = [0, 1, -1, 2, -2].map(|offset| x + offset);
            if let Some(free) = near.into_iter().find(|&column| !is_taken(column)) {
                ends[at] = free;
            }
        }
    }
    let mut tracks: Vec<Vec<(i32, i32)>> = Vec::new();
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_by_key(|&at| (begins[at].min(ends[at]), at));
    let mut track = vec![None; pieces.len()];
    for at in order {
        let (left, right) = (begins[at].min(ends[at]), begins[at].max(ends[at]));
        if left == right {
            continue;
        }
        let fits = |row: &Vec<(i32, i32)>| row.iter().all(|&(l, r)| right < l - 1 || left > r + 1);
        let free = tracks.iter().position(fits).unwrap_or_else(|| {
            tracks.push(Vec::new());
            tracks.len() - 1
        });
        tracks[free].push((left, right));
        track[at] = i32::try_from(free).ok();
    }
    let count = i32::try_from(tracks.len()).unwrap_or(0);
    let end = top + count + 1;
    let routed = pieces.iter().enumerate().map(|(at, piece)| {
        let (from, to) = (begins[at], ends[at]);
        let mut corners = vec![Spot { x: from, y: piece.bottom }];
        if let Some(track) = track[at] {
            let y = top + track;
            corners.extend([Spot { x: from, y }, Spot { x: to, y }]);
        }
        corners.push(Spot { x: to, y: end });
        // If the line only passes through the lower layer, the next piece continues it.
        (piece.arc, corners)
    });
    (count, routed.collect())
}

/// Lines between elements with given positions: straight down if possible, otherwise around.
pub(super) fn around(drawn: &[Drawn], ends: &[(usize, usize)]) -> Vec<Vec<Spot>> {
    let right = drawn.iter().map(|one| one.at.x + one.reach.1).max().unwrap_or(0);
    let mut lane = right + 2;
    let mut leaving = vec![0usize; drawn.len()];
    let mut coming = vec![0usize; drawn.len()];
    let totals = |of: fn(&(usize, usize)) -> usize| {
        ends.iter().fold(vec![0usize; drawn.len()], |mut sum, end| {
            sum[of(end)] += 1;
            sum
        })
    };
    let (out, into) = (totals(|end| end.0), totals(|end| end.1));
    ends.iter()
        .map(|&(from, to)| {
            let port = |one: usize, seen: &mut Vec<usize>, total: &[usize]| {
                let offset = ports(total[one]).get(seen[one]).copied().unwrap_or(0);
                seen[one] += 1;
                drawn[one].at.x + offset
            };
            let (x, end) = (port(from, &mut leaving, &out), port(to, &mut coming, &into));
            let begin = Spot { x, y: drawn[from].at.y + drawn[from].rows };
            let end = Spot { x: end, y: drawn[to].at.y - 1 };
            if end.y >= begin.y {
                let y = (begin.y + end.y) / 2;
                return vec![begin, Spot { x: begin.x, y }, Spot { x: end.x, y }, end];
            }
            lane += 2;
            vec![
                begin,
                Spot { x: begin.x, y: begin.y + 1 },
                Spot { x: lane, y: begin.y + 1 },
                Spot { x: lane, y: end.y - 1 },
                Spot { x: end.x, y: end.y - 1 },
                end,
            ]
        })
        .map(|mut corners| {
            corners.dedup();
            corners
        })
        .collect()
}
