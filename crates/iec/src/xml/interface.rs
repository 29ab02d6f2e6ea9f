//! Reads the declarations of variables and types.

use super::node::{Text, child, children, elements, is};
use crate::ast::{Argument, Expr, Listing};
use crate::fault::Fault;
use crate::{Section, TypeRef, Variable, parse, same};
use roxmltree::Node;

/// The variables of an interface or of a list of global variables.
pub(super) fn variables(text: &Text, node: Node<'_, '_>) -> Vec<Variable> {
    let mut found = Vec::new();
    for list in elements(node) {
        let section = match list.tag_name().name() {
            "localVars" => Section::Local,
            "tempVars" => Section::Temp,
            "inputVars" => Section::Input,
            "outputVars" => Section::Output,
            "inOutVars" => Section::InOut,
            "externalVars" => Section::External,
            "globalVars" => Section::Global,
            _ => continue,
        };
        found.extend(list_of(text, list, section));
    }
    retain_mixed(node, &mut found);
    found
}

/// If the variables of a section have different attributes, CODESYS writes these in additional data of the unit or
/// list. Marks the retained ones.
pub(super) fn retain_mixed(node: Node<'_, '_>, found: &mut [Variable]) {
    let beside = node.parent().into_iter().flat_map(|parent| children(parent, "addData"));
    let around = std::iter::once(node).chain(beside).flat_map(|one| one.descendants());
    let mixed = around.filter(|one| one.tag_name().name() == "MixedAttrsVarList");
    for list in mixed.flat_map(elements).filter(|list| is_retained(*list)) {
        let named = |own: &Variable| {
            children(list, "variable")
                .any(|one| one.attribute("name").is_some_and(|name| same(name, &own.name)))
        };
        found.iter_mut().for_each(|own| own.retain |= named(own));
    }
}

fn is_retained(list: Node<'_, '_>) -> bool {
    is(list, "retain") || is(list, "persistent")
}

/// The variables of one section.
pub(super) fn list_of(text: &Text, list: Node<'_, '_>, section: Section) -> Vec<Variable> {
    children(list, "variable")
        .filter_map(|one| {
            let line = text.line(one);
            let of = child(one, "type").map(|of| type_ref(text, of));
            let of = of.unwrap_or_else(|| TypeRef::Named(String::new()));
            let begins = child(one, "initialValue");
            let initial =
                begins.map(|value| begins_with(value, line)).or_else(|| constructed(one, line));
            Some(Variable {
                initial,
                at: one.attribute("address").map(str::to_ascii_uppercase),
                constant: is(list, "constant"),
                retain: is_retained(list),
                ..Variable::new(one.attribute("name")?, section, of, line)
            })
        })
        .collect()
}

/// The arguments of an instance's FB_Init, as CODESYS and TwinCAT write them; `None` if there are none.
fn constructed(variable: Node<'_, '_>, line: u32) -> Option<Expr> {
    let inside = child(variable, "addData")?.descendants();
    let all = inside.filter(|one| one.tag_name().name() == "InputAssignment");
    let given: Vec<Argument> = all
        .filter_map(|one| {
            let name = child(one, "Name")?.text()?.trim().to_owned();
            let text = child(one, "Value")?.text().unwrap_or_default();
            let some = || Expr::List(Listing::Unread, Vec::new());
            let value = parse::expression(text, line).unwrap_or_else(|_| some());
            Some(Argument { name: Some(name), is_output: false, value })
        })
        .collect();
    (!given.is_empty()).then_some(Expr::List(Listing::Parts, given))
}

/// The initial value in an element, or text in place of one. An empty or unreadable value becomes [`Listing::Unread`],
/// an unknown value.
pub(super) fn begins_with(node: Node<'_, '_>, line: u32) -> Expr {
    let some = || Expr::List(Listing::Unread, Vec::new());
    let texts = node.children().filter(Node::is_text).filter_map(|one| one.text());
    let text: String = texts.collect();
    let mut values = elements(node);
    match (values.next(), values.next(), text.trim()) {
        (Some(value), None, "") => initial(value, line),
        (None, _, text) => parse::expression(text, line).unwrap_or_else(|_| some()),
        _ => some(),
    }
}

/// The initial value of a value element; an unreadable one becomes [`Listing::Unread`].
fn initial(value: Node<'_, '_>, line: u32) -> Expr {
    let some = || Expr::List(Listing::Unread, Vec::new());
    let named = |(name, one): (Option<&str>, Node<'_, '_>)| {
        let value = begins_with(one, line);
        Argument { name: name.map(str::to_owned), is_output: false, value }
    };
    let kind = value.tag_name().name();
    if kind == "arrayValue" {
        let mut given = Vec::new();
        let mut listed = 0_usize;
        for one in children(value, "value") {
            let times =
                one.attribute("repetitionValue").map_or(Ok(1), |times| times.trim().parse());
            let one = named((None, one));
            let times = times.unwrap_or(usize::MAX);
            listed = listed.saturating_add(parse::values_in(&one.value).saturating_mul(times));
            if listed > parse::MAX_LISTED {
                return some();
            }
            given.extend(std::iter::repeat_n(one, times));
        }
        return Expr::List(Listing::Elements, given);
    }
    if kind == "structValue" {
        let given = children(value, "value").map(|one| named((one.attribute("member"), one)));
        return Expr::List(Listing::Parts, given.collect());
    }
    let text = value.attribute("value").filter(|_| kind == "simpleValue");
    text.and_then(|text| parse::expression(text, line).ok()).unwrap_or_else(some)
}

/// The type in an element; a type with an empty name if there is none.
pub(super) fn type_ref(text: &Text, node: Node<'_, '_>) -> TypeRef {
    let Some(of) = elements(node).next() else { return TypeRef::Named(String::new()) };
    let base = || child(of, "baseType").map(|base| type_ref(text, base));
    let any = || TypeRef::Named(String::new());
    match of.tag_name().name() {
        "derived" => {
            let name = of.attribute("name").unwrap_or_default();
            parse::type_ref(name, 1).unwrap_or_else(|_| TypeRef::Named(name.to_owned()))
        }
        "array" => {
            let dimensions = children(of, "dimension").map(|one| {
                let bound = |name| {
                    let written = one.attribute(name).unwrap_or_default();
                    parse::expression(written, text.line(one)).unwrap_or_else(|_| Expr::name(""))
                };
                (bound("lower"), bound("upper"))
            });
            TypeRef::Array(dimensions.collect(), Box::new(base().unwrap_or_else(any)))
        }
        "string" | "wstring" | "STRING" | "WSTRING" => {
            let written = of.attribute("length");
            let length = written.and_then(|one| parse::expression(one, text.line(of)).ok());
            TypeRef::Text(length.map(Box::new))
        }
        "pointer" => TypeRef::Pointer(Box::new(base().unwrap_or_else(any))),
        "struct" => TypeRef::Struct(list_of(text, of, Section::Local)),
        "enum" => {
            let values =
                child(of, "values").into_iter().flat_map(|values| children(values, "value"));
            let value = |one: Node<'_, '_>| {
                let number = one.attribute("value");
                let number =
                    number.and_then(|number| parse::expression(number, text.line(one)).ok());
                Some((one.attribute("name")?.to_owned(), number))
            };
            TypeRef::Enumeration(values.filter_map(value).collect(), base().map(Box::new))
        }
        "subrangeSigned" | "subrangeUnsigned" => {
            let bound = |name| {
                let written = child(of, "range").and_then(|range| range.attribute(name));
                parse::expression(written.unwrap_or_default(), text.line(of))
                    .unwrap_or_else(|_| Expr::name(""))
            };
            let range = Box::new((bound("lower"), bound("upper")));
            TypeRef::Subrange(Box::new(base().unwrap_or_else(any)), range)
        }
        name => TypeRef::Named(name.to_owned()),
    }
}

/// Adds addresses and attributes from the declaration as text, which TwinCAT and CODESYS write beside the elements.
///
/// # Errors
/// A pragma or comment in it that is not supported, or a text that cannot be read and may say more than the elements.
pub(super) fn addresses(variables: &mut Vec<Variable>, declaration: &str) -> Result<(), Fault> {
    parse::pragmas(declaration)?;
    let written = match parse::declarations(declaration, 1) {
        Ok(written) => written,
        // The elements contain the same, except for these words.
        Err(fault) => {
            let mut words = declaration.split(|c: char| !c.is_alphanumeric() && c != '_');
            let says_more = words.any(|word| {
                ["AT", "CONSTANT", "VAR_STAT", "VAR_INST"].iter().any(|more| same(word, more))
            });
            return if says_more { Err(fault) } else { Ok(()) };
        }
    };
    let is_apart = |one: &&Variable| matches!(one.section, Section::Static | Section::Instance);
    // Variables that have no section in the elements.
    for one in written.iter().filter(is_apart) {
        variables.retain(|own| !same(&own.name, &one.name));
        variables.push(one.clone());
    }
    for variable in variables {
        if let Some(other) = written.iter().find(|other| same(&other.name, &variable.name)) {
            variable.at = variable.at.take().or_else(|| other.at.clone());
            variable.constant |= other.constant;
            variable.retain |= other.retain;
        }
    }
    Ok(())
}

/// The function block that a declaration as text extends, if any.
pub(super) fn extends(declaration: &str) -> Option<String> {
    let mut words = declaration.split_whitespace();
    words.find(|word| same(word, "FUNCTION_BLOCK"))?;
    words.next()?;
    words.next().filter(|word| same(word, "EXTENDS"))?;
    words.next().map(|name| name.trim_end_matches([';', ',']).to_owned())
}
