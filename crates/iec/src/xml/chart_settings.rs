//! What the settings of CODESYS and TwinCAT say of a chart.

use super::node::{Text, added, children, elements};
use crate::body::{Body, ChartSettings};
use crate::chart::CONTROL_FLAGS;
use crate::{Section, TypeRef, Variable, same};
use roxmltree::Node;

/// The flags that the settings of a chart use and that the tool declares itself, so that they are not among the
/// variables, or for which it executes code.
pub(super) fn declared_flags<'a>(settings: Node<'a, 'a>) -> impl Iterator<Item = String> + 'a {
    settings.descendants().filter_map(|one| {
        let name = flag_name(one);
        let is_declared = CONTROL_FLAGS.contains(&&*name) && is_set(one, "Declare");
        (is_set(one, "Use") && (is_declared || name.contains("Analyzation"))).then_some(name)
    })
}

/// Reads the settings of the chart of a unit or action (`node`), if it has one: declares the variables for the flags
/// that the tool declares. Each chart has its own: whether tools declare one for several charts is not known. `plain`:
/// the text in which the unit declares its variables.
pub(super) fn apply(
    text: &Text,
    node: Node<'_, '_>,
    plain: &str,
    (body, variables): (&mut Body, &mut Vec<Variable>),
) {
    let Body::Chart(chart) = body else { return };
    let settings = added(node).find(|one| one.tag_name().name() == "SFCSettings");
    let Some(settings) = settings else { return };
    chart.settings = stated(text, settings, plain, variables);
    let used: Vec<String> = declared_flags(settings).collect();
    let owner = node.attribute("name").unwrap_or_default();
    for (place, flag) in CONTROL_FLAGS[..2].iter().enumerate() {
        if used.iter().any(|used| used == flag) {
            let name = format!("{flag} of {owner}");
            let of = TypeRef::Named("BOOL".to_owned());
            let line = text.line(node);
            variables.push(Variable::new(name.clone(), Section::Local, of, line));
            chart.restart_flags[place] = Some(name);
        }
    }
}

/// What the settings of a chart certainly say. `variables`: those of its unit.
fn stated(
    text: &Text,
    settings: Node<'_, '_>,
    plain: &str,
    variables: &[Variable],
) -> ChartSettings {
    // Some versions misspell the name of a setting, so that its beginning decides.
    let says = |name: &str, value: &str| {
        let mut all = elements(settings).filter(|one| one.tag_name().name().starts_with(name));
        let is_it = |one: Node<'_, '_>| {
            one.text().is_some_and(|text| text.trim().eq_ignore_ascii_case(value))
        };
        all.next().is_some_and(is_it) && all.next().is_none()
    };
    // With UseDefaults, the settings of the project hold, which are not in the file.
    if !text.is_codesys || says("UseDefaults", "true") {
        return ChartSettings::default();
    }
    let is_certain = says("UseDefaults", "false");
    let only_active = says("CalcActiveTra", "true");
    let all = is_certain && says("CalcActiveTra", "false");
    let evaluates_all = (only_active || all).then_some(all);
    let flags: Vec<Node<'_, '_>> = children(settings, "Flags").flat_map(elements).collect();
    let restarts: Vec<Option<Node<'_, '_>>> = CONTROL_FLAGS[..2]
        .iter()
        .map(|flag| flags.iter().copied().find(|&one| flag_name(one) == **flag))
        .collect();
    let words: Vec<&str> =
        plain.split(|at: char| !(at.is_ascii_alphanumeric() || at == '_')).collect();
    let is_written = |flag: &str| words.iter().any(|word| same(word, flag));
    let is_listed = |flag: &str| variables.iter().any(|one| same(&one.name, flag));
    let is_declared = |one: &Node<'_, '_>| is_set(*one, "Use") && is_set(*one, "Declare");
    // The interface lists the flags that the tool has declared, which the text of the declarations does not have.
    let declares = |flag: &str| is_listed(flag) && !is_written(flag);
    let lists_declared = !plain.trim().is_empty()
        && restarts.iter().flatten().any(|one| is_declared(one) && declares(&flag_name(*one)));
    let controls = |one: &Option<Node<'_, '_>>| {
        one.is_some_and(|one| is_set(one, "Use") && is_listed(&flag_name(one)))
    };
    let flags_control = is_certain && lists_declared && restarts.iter().all(controls);
    ChartSettings { flags_control, evaluates_all }
}

/// The name of the flag of which an element of the settings tells.
fn flag_name(one: Node<'_, '_>) -> String {
    let name = one.tag_name().name();
    format!("SFC{}", name.strip_prefix("SFC").unwrap_or(name))
}

fn is_set(one: Node<'_, '_>, name: &str) -> bool {
    one.attribute(name).is_some_and(|set| set.eq_ignore_ascii_case("true"))
}
