//! Arranges elements in layers, so that arcs lead down where possible and few lines cross.

use super::drawn::{Drawn, Spot};
use super::route::{self, Piece};

/// The distance of elements in one layer, in columns.
const APART: i32 = 3;
/// The number of passes for the ordering of layers.
const SWEEPS: usize = 12;

/// An element, or a point where a line passes through a layer.
#[derive(Debug, Clone, Copy)]
struct Vertex {
    layer: usize,
    /// The element; `None` for a line.
    drawn: Option<usize>,
    x: i32,
}

/// Places the elements, and returns the corners of each arc. The elements in `first` begin the layers.
pub(super) fn laid_out(
    drawn: &mut [Drawn],
    ends: &[(usize, usize)],
    first: &[usize],
) -> Vec<Vec<Spot>> {
    let turned = turned(drawn.len(), ends, first);
    let down = |arc: usize| {
        let (from, to) = ends[arc];
        if turned[arc] { (to, from) } else { (from, to) }
    };
    let layer = layer_numbers(drawn.len(), &(0..ends.len()).map(down).collect::<Vec<_>>());
    let mut vertices: Vec<Vertex> = layer
        .iter()
        .enumerate()
        .map(|(at, &layer)| Vertex { layer, drawn: Some(at), x: 0 })
        .collect();
    // Each arc as a path through all layers between its ends.
    let mut ways: Vec<Vec<usize>> = Vec::new();
    for arc in 0..ends.len() {
        let (upper, lower) = down(arc);
        let mut way = vec![upper];
        for layer in layer[upper] + 1..layer[lower] {
            way.push(vertices.len());
            vertices.push(Vertex { layer, drawn: None, x: 0 });
        }
        way.push(lower);
        ways.push(way);
    }
    let count = vertices.iter().map(|one| one.layer).max().map_or(0, |last| last + 1);
    let mut layers: Vec<Vec<usize>> = vec![Vec::new(); count];
    for (at, vertex) in vertices.iter().enumerate() {
        layers[vertex.layer].push(at);
    }
    let (mut above, mut below) =
        (vec![Vec::new(); vertices.len()], vec![Vec::new(); vertices.len()]);
    for pair in ways.iter().flat_map(|way| way.windows(2)) {
        above[pair[1]].push(pair[0]);
        below[pair[0]].push(pair[1]);
    }
    order(&mut layers, &above, &below);
    columns(&mut vertices, &layers, drawn, &above, &below);
    // Rows: after each layer a channel with as many tracks as its lines need.
    let mut corners: Vec<Vec<Spot>> = vec![Vec::new(); ends.len()];
    let mut top = 1;
    for (at, layer) in layers.iter().enumerate() {
        let rows = layer.iter().filter_map(|&one| Some(drawn[vertices[one].drawn?].rows));
        let rows = rows.max().unwrap_or(1);
        for &one in layer {
            if let Some(own) = vertices[one].drawn {
                drawn[own].at = Spot { x: vertices[one].x, y: top };
            }
        }
        let pieces: Vec<Piece> = ways
            .iter()
            .enumerate()
            .flat_map(|(arc, way)| way.windows(2).map(move |pair| (arc, pair[0], pair[1])))
            .filter(|(_, upper, _)| vertices[*upper].layer == at)
            .map(|(arc, upper, lower)| {
                let end = |one: usize| {
                    let vertex = vertices[one];
                    (one, vertex.x, vertex.drawn.is_some())
                };
                let bottom = vertices[upper].drawn.map_or(top, |own| top + drawn[own].rows);
                Piece { arc, upper: end(upper), lower: end(lower), bottom }
            })
            .collect();
        let (tracks, routed) = route::channel(&pieces, top + rows + 1);
        for (arc, more) in routed {
            corners[arc].extend(more);
        }
        top += rows + tracks + 3;
    }
    for (arc, own) in corners.iter_mut().enumerate() {
        if turned[arc] {
            own.reverse();
        }
        own.dedup();
    }
    corners
}

/// The arcs that lead back; without them there are no cycles.
fn turned(count: usize, ends: &[(usize, usize)], first: &[usize]) -> Vec<bool> {
    let mut next: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut has_input = vec![false; count];
    for (arc, &(from, to)) in ends.iter().enumerate() {
        next[from].push(arc);
        has_input[to] = true;
    }
    let sources = (0..count).filter(|&one| !has_input[one]);
    let begins: Vec<usize> = first.iter().copied().chain(sources).chain(0..count).collect();
    let (mut turned, mut state) = (vec![false; ends.len()], vec![0u8; count]);
    for begin in begins {
        if state[begin] != 0 {
            continue;
        }
        state[begin] = 1;
        let mut open = vec![(begin, 0)];
        while let Some((node, at)) = open.last_mut() {
            let Some(&arc) = next[*node].get(*at) else {
                state[*node] = 2;
                open.pop();
                continue;
            };
            *at += 1;
            let to = ends[arc].1;
            match state[to] {
                0 => {
                    state[to] = 1;
                    open.push((to, 0));
                }
                1 => turned[arc] = true,
                _ => {}
            }
        }
    }
    turned
}

/// Each element's layer: one below the lowest element that leads to it.
fn layer_numbers(count: usize, down: &[(usize, usize)]) -> Vec<usize> {
    let mut layer = vec![0; count];
    // Without cycles, no path is longer than the number of elements.
    for _ in 0..count {
        let mut changed = false;
        for &(upper, lower) in down {
            if layer[lower] <= layer[upper] {
                layer[lower] = layer[upper] + 1;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    // An element without inputs is placed just above those that it leads to.
    for _ in 0..count {
        let mut changed = false;
        for one in 0..count {
            let is_source = down.iter().all(|&(_, lower)| lower != one);
            let least = down.iter().filter(|(upper, _)| *upper == one).map(|(_, to)| layer[*to]);
            if let (true, Some(least)) = (is_source, least.min())
                && layer[one] + 1 < least
            {
                layer[one] = least - 1;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    layer
}

/// Orders each layer by the positions of neighbours, so that few lines cross.
fn order(layers: &mut [Vec<usize>], above: &[Vec<usize>], below: &[Vec<usize>]) {
    let mut place = vec![0usize; above.len()];
    let note = |layer: &[usize], place: &mut Vec<usize>| {
        for (at, &one) in layer.iter().enumerate() {
            place[one] = at;
        }
    };
    layers.iter().for_each(|layer| note(layer, &mut place));
    for sweep in 0..SWEEPS {
        let goes_down = sweep % 2 == 0;
        let neighbours = if goes_down { above } else { below };
        let count = layers.len();
        for step in 0..count {
            let layer = &mut layers[if goes_down { step } else { count - 1 - step }];
            // The mean in thousandths; an element without neighbours stays where it is.
            let key = |one: usize| match neighbours[one].len() {
                0 => place[one] * 1000,
                len => {
                    neighbours[one].iter().map(|&other| place[other] * 1000).sum::<usize>() / len
                }
            };
            let mut keyed: Vec<(usize, usize)> = layer.iter().map(|&one| (key(one), one)).collect();
            keyed.sort_by_key(|(key, _)| *key);
            *layer = keyed.into_iter().map(|(_, one)| one).collect();
            note(layer, &mut place);
        }
    }
}

/// Assigns columns, each as near as possible to the mean of its neighbours.
fn columns(
    vertices: &mut [Vertex],
    layers: &[Vec<usize>],
    drawn: &[Drawn],
    above: &[Vec<usize>],
    below: &[Vec<usize>],
) {
    let reach = |vertex: &Vertex| vertex.drawn.map_or((0, 0), |own| drawn[own].reach);
    let apart: Vec<Vec<i32>> = layers
        .iter()
        .map(|layer| {
            let pair =
                |pair: &[usize]| reach(&vertices[pair[0]]).1 + reach(&vertices[pair[1]]).0 + APART;
            layer.windows(2).map(pair).collect()
        })
        .collect();
    for (layer, apart) in layers.iter().zip(&apart) {
        let mut x = 0;
        for (at, &one) in layer.iter().enumerate() {
            x += if at == 0 { 0 } else { apart[at - 1] };
            vertices[one].x = x;
        }
    }
    for sweep in 0..SWEEPS {
        let count = layers.len();
        for step in 0..count {
            let at = if sweep % 2 == 0 { step } else { count - 1 - step };
            let layer = &layers[at];
            let wished: Vec<i32> = layer
                .iter()
                .map(|&one| {
                    let near: Vec<i32> = above[one]
                        .iter()
                        .chain(&below[one])
                        .map(|&other| vertices[other].x)
                        .collect();
                    let len = i32::try_from(near.len()).unwrap_or(1);
                    if near.is_empty() { vertices[one].x } else { near.iter().sum::<i32>() / len }
                })
                .collect();
            for (&one, x) in layer.iter().zip(fitted(&wished, &apart[at])) {
                vertices[one].x = x;
            }
        }
    }
    let left = vertices.iter().map(|vertex| vertex.x - reach(vertex).0).min().unwrap_or(0);
    vertices.iter_mut().for_each(|vertex| vertex.x += 1 - left);
}

/// Columns as near as possible to the wished ones, in the same order and with these distances: neighbours that would be
/// too near form a group around the mean of their wishes.
fn fitted(wished: &[i32], apart: &[i32]) -> Vec<i32> {
    let mut offset = vec![0; wished.len()];
    for at in 1..wished.len() {
        offset[at] = offset[at - 1] + apart[at - 1];
    }
    // Groups: the sum of the wishes, and the number of members.
    let mut groups: Vec<(i64, i64)> = Vec::new();
    for (wish, offset) in wished.iter().zip(&offset) {
        let mut group = (i64::from(wish - offset), 1);
        while let Some(&(sum, count)) = groups.last() {
            if sum * group.1 < group.0 * count {
                break;
            }
            groups.pop();
            group = (group.0 + sum, group.1 + count);
        }
        groups.push(group);
    }
    let mut columns = Vec::new();
    for (sum, count) in groups {
        let mean = i32::try_from(sum.div_euclid(count)).unwrap_or(0);
        for _ in 0..count {
            columns.push(mean + offset[columns.len()]);
        }
    }
    columns
}
