//! Charts as Petri nets for Graphviz.

use super::{Study, rows};
use std::fmt::Write;

/// One graph, a cluster a chart: steps are places, drawn as boxes with their actions, transitions are bars.
#[must_use]
pub fn render(studies: &[Study<'_>]) -> String {
    let mut text = "digraph sfc {\n  rankdir=TB;\n  node [fontname=\"sans-serif\"];\n".to_owned();
    for (number, study) in studies.iter().enumerate() {
        let _ = writeln!(
            text,
            "  subgraph cluster_{number} {{\n    label=\"{}\";",
            escaped(&study.name)
        );
        for (at, step) in study.chart.steps.iter().enumerate() {
            // Macro steps are clusters, opened at their first step and closed behind their last; each comes behind
            // those that it stands in.
            for (own, one) in study.chart.macros.iter().enumerate() {
                if one.steps.first() == Some(&at) {
                    let name = escaped(&one.name);
                    let _ = writeln!(
                        text,
                        "    subgraph cluster_{number}_{own} {{ style=dashed; label=\"{name}\";"
                    );
                }
            }
            let blocks: String = rows(step)
                .map(|row| format!("\\n{} {}", row.qualifier, escaped(&row.action)))
                .collect();
            let border = if step.initial { ", peripheries=2" } else { "" };
            let _ = writeln!(
                text,
                "    s{number}_{at} [shape=box, label=\"{}{blocks}\"{border}];",
                escaped(&step.name)
            );
            for one in &study.chart.macros {
                if one.steps.last() == Some(&at) {
                    text += "    }\n";
                }
            }
        }
        for (at, one) in study.chart.transitions.iter().enumerate() {
            let condition = escaped(&scanbound_iec::show::expr(&one.condition));
            let _ = writeln!(
                text,
                "    t{number}_{at} [shape=box, style=filled, fillcolor=black, height=0.05, label=\"\", xlabel=\"{condition}\"];"
            );
            for step in &one.from {
                let _ = writeln!(text, "    s{number}_{step} -> t{number}_{at};");
            }
            for step in &one.to {
                let _ = writeln!(text, "    t{number}_{at} -> s{number}_{step};");
            }
        }
        text += "  }\n";
    }
    text + "}\n"
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"")
}
