//! Groups of commands in the help of the program.

use clap::Command;

/// Groups with their commands. The last group takes all commands that no other group contains.
const GROUPS: [(&str, &[&str]); 4] = [
    ("First steps", &["run", "sweep", "solve", "optimise", "import", "advise", "design", "link", "explain"]),
    ("Scenes", &["list", "show", "check", "schema"]),
    ("Results", &["compare", "merge", "spectrum", "validate", "export"]),
    ("Other", &[]),
];

/// Lists the commands in groups.
pub(super) fn add(command: Command) -> Command {
    let mut built = command.clone();
    built.build();
    let (header, literal) = (*built.get_styles().get_header(), *built.get_styles().get_literal());
    let width = built.get_subcommands().map(|command| command.get_name().len()).max().unwrap_or(0);
    let mut list = String::new();
    for (title, names) in GROUPS {
        list += &format!("{header}{title}:{header:#}\n");
        let mut commands: Vec<&Command> = built.get_subcommands().filter(|command| group(command.get_name()) == names).collect();
        commands.sort_by_key(|command| names.iter().position(|name| *name == command.get_name()));
        for command in commands {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            list += &format!("  {literal}{:width$}{literal:#}  {about}\n", command.get_name());
        }
        list += "\n";
    }
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{list}{header}Options:{header:#}\n{{options}}{{after-help}}"
    ))
}

/// Returns the commands of the group that contains a command.
fn group(name: &str) -> &'static [&'static str] {
    GROUPS.iter().map(|(_, names)| *names).find(|names| names.contains(&name)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::GROUPS;

    #[test]
    fn the_help_lists_every_command_once_in_its_group() {
        let mut command = super::super::command();
        let help = command.render_long_help().to_string();
        let listed: Vec<&str> = help.lines().filter_map(|line| line.strip_prefix("  ")?.split("  ").next()).collect();
        let all = command.get_subcommands().map(clap::Command::get_name);
        for name in all.chain(GROUPS.iter().flat_map(|(_, names)| *names).copied()) {
            assert_eq!(listed.iter().filter(|listed| **listed == name).count(), 1, "{name}\n{help}");
        }
        assert_eq!(listed[..GROUPS[0].1.len()], *GROUPS[0].1);
    }
}
