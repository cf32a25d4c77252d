//! Rules of FMI 3.0.2, section 2.4.9.

use super::super::tree::Element;
use super::common::Linter;

/// The rules of wiring that the standard defines; others are tools' own.
const MATCHING_RULES: [&str; 3] = ["plug", "bus", "sequence"];

impl Linter {
    pub(super) fn terminals(&mut self, root: &Element, variables: &[Element]) {
        if root.name != "fmiTerminalsAndIcons"
            || root.attribute("fmiVersion").is_none_or(|version| !version.starts_with("3."))
        {
            let message = "the root is not fmiTerminalsAndIcons of a fmiVersion \"3.0\"";
            self.error(root, "version", message, "FMI 3.0 is what is checked");
        }
        self.terminal_list(root.list("Terminals"), variables);
    }

    fn terminal_list(&mut self, terminals: &[Element], variables: &[Element]) {
        self.distinct(terminals, "terminal");
        for terminal in terminals {
            let name = terminal.attribute("name").unwrap_or_default();
            let rule = terminal.attribute("matchingRule").unwrap_or_default();
            if !MATCHING_RULES.contains(&rule) && !rule.contains('.') {
                let message = format!("matchingRule=\"{rule}\" of terminal \"{name}\"");
                let help = "use plug, bus or sequence, or a name in reverse domain notation";
                self.error(terminal, "matching-rule", message, help);
            }
            self.members(terminal, name, rule, variables);
            let nested: Vec<Element> =
                terminal.children.iter().filter(|c| c.name == "Terminal").cloned().collect();
            self.terminal_list(&nested, variables);
        }
    }

    fn members(&mut self, terminal: &Element, name: &str, rule: &str, variables: &[Element]) {
        let members: Vec<&Element> = terminal
            .children
            .iter()
            .filter(|child| child.name == "TerminalMemberVariable")
            .collect();
        for (i, &member) in members.iter().enumerate() {
            let variable = member.attribute("variableName").unwrap_or_default();
            if !variables.iter().any(|v| v.attribute("name") == Some(variable)) {
                let message =
                    format!("terminal \"{name}\" names \"{variable}\", which is no variable");
                self.error(member, "unknown-variable", message, "name one of modelDescription.xml");
            }
            let member_name = member.attribute("memberName");
            if member_name.is_none() && matches!(rule, "plug" | "bus") {
                let message = format!("\"{variable}\" of terminal \"{name}\" has no memberName");
                self.error(
                    member,
                    "member-name",
                    message,
                    "members are matched by it: give it one",
                );
            }
            let before = members.iter().take(i);
            if member_name.is_some()
                && before
                    .map(|other| other.attribute("memberName"))
                    .any(|other| other == member_name)
            {
                let message = format!("terminal \"{name}\" has a memberName twice");
                self.error(member, "duplicate-name", message, "names must be unique");
            }
        }
    }
}
