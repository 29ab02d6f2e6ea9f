//! S-nets as pictures: SVG, DOT, and on a terminal, with what a simulation or a PLC shows in them.

pub mod dot;
pub mod readings;
#[cfg(feature = "screen")]
pub mod screen;
pub mod svg;
pub mod trace;

use scanbound_snet::monitor::Reading;
use scanbound_snet::picture::seconds;
use scanbound_snet::simulation::Simulation;
use scanbound_snet::{Diagram, Kind};

/// What is shown of a place.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PlaceView {
    /// Whether it is marked; none where that is not known.
    pub is_marked: Option<bool>,
    /// Whether its timer is over, or its counter has counted up.
    pub is_over: bool,
    /// What its timer or counter stands at, in place of what it is set to.
    pub standing: Option<String>,
}

/// What a picture shows besides the net.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct View {
    /// By place.
    pub places: Vec<PlaceView>,
    /// By transition: whether it is lit.
    pub lit: Vec<bool>,
    /// By outer gate; none where that is not known.
    pub outers: Vec<Option<bool>>,
    /// Whether it is out of date.
    pub is_old: bool,
}

impl View {
    /// The marks with which a net begins.
    #[must_use]
    pub fn initial(diagram: &Diagram) -> View {
        let place = |is_marked| PlaceView { is_marked: Some(is_marked), ..PlaceView::default() };
        View {
            places: diagram.places.iter().map(|one| place(one.is_marked)).collect(),
            lit: vec![false; diagram.transitions.len()],
            outers: vec![None; diagram.outers.len()],
            is_old: false,
        }
    }

    /// A net of whose places it is known whether they are marked, or not known.
    #[must_use]
    pub fn marked(diagram: &Diagram, marked: &[Option<bool>]) -> View {
        let place = |&is_marked: &Option<bool>| PlaceView { is_marked, ..PlaceView::default() };
        View { places: marked.iter().map(place).collect(), ..View::initial(diagram) }
    }

    /// A net of which nothing is known yet.
    #[must_use]
    pub fn unknown(diagram: &Diagram) -> View {
        let places = vec![PlaceView::default(); diagram.places.len()];
        View { places, ..View::initial(diagram) }
    }

    /// A simulation: what can fire is lit.
    #[must_use]
    pub fn simulated(net: &Simulation<'_>) -> View {
        let (diagram, rules, now) = (net.diagram(), net.rules(), net.now());
        let places = diagram.places.iter().enumerate().map(|(at, place)| {
            let standing = match place.kind {
                Kind::Box => None,
                Kind::Timer { tenths, .. } => {
                    let gone = net.elapsed(at);
                    Some(format!("{}.{}/{}", gone / 10, gone % 10, seconds(tenths)))
                }
                Kind::Counter { count, .. } => {
                    Some(format!("{}/{count}", rules.count(&now.state, at)))
                }
            };
            PlaceView {
                is_marked: Some(rules.is_marked(&now.state, at)),
                is_over: rules.is_over(&now.state, at),
                standing,
            }
        });
        let mut lit = vec![false; diagram.transitions.len()];
        net.firable().into_iter().for_each(|at| lit[at] = true);
        View {
            places: places.collect(),
            lit,
            outers: now.outers.iter().map(|&on| Some(on)).collect(),
            is_old: false,
        }
    }

    /// What was read from a PLC.
    #[must_use]
    pub fn read(diagram: &Diagram, reading: &Reading) -> View {
        let known =
            |value: Option<u16>| value.map_or_else(|| "?".to_owned(), |one| one.to_string());
        let time = |value: Option<u16>| {
            value
                .map_or_else(|| "?".to_owned(), |tenths| format!("{}.{}", tenths / 10, tenths % 10))
        };
        let places = diagram.places.iter().zip(&reading.places).map(|(place, shown)| {
            let standing = match place.kind {
                Kind::Box => None,
                Kind::Timer { .. } => {
                    let set = shown.setting.map_or_else(|| "?".to_owned(), seconds);
                    Some(format!("{}/{set}", time(shown.elapsed())))
                }
                Kind::Counter { .. } => {
                    Some(format!("{}/{}", known(shown.elapsed()), known(shown.setting)))
                }
            };
            let is_marked = match place.kind {
                Kind::Counter { .. } => shown.over,
                Kind::Box | Kind::Timer { .. } => shown.relay,
            };
            PlaceView { is_marked, is_over: shown.over == Some(true), standing }
        });
        View {
            places: places.collect(),
            lit: reading.transitions.iter().map(|on| *on == Some(true)).collect(),
            outers: reading.outers.clone(),
            is_old: false,
        }
    }
}
