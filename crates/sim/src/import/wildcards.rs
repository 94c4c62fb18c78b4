//! Names of files with wildcards, as Python's glob has them: `*`, `?`, `[a-c]` and `[!a]`.

use super::Files;

/// What makes a name a pattern.
const WILD: [char; 3] = ['*', '?', '['];

/// Folder and pattern of a name with wildcards; `None` of a plain name.
pub(super) fn parts(name: &str) -> Option<(&str, &str)> {
    let parts = name.rsplit_once('/').unwrap_or(("", name));
    name.contains(WILD).then_some(parts)
}

/// The files of a folder that a pattern matches, in the order of their names.
///
/// # Errors
/// Why there is no telling them.
pub(super) fn matching(
    folder: &str,
    pattern: &str,
    files: Files<'_>,
) -> Result<Vec<String>, String> {
    if folder.contains(WILD) {
        return Err("wildcards in the name of a folder".to_owned());
    }
    let pattern = glob::Pattern::new(pattern).map_err(|error| error.to_string())?;
    let options = glob::MatchOptions {
        require_literal_leading_dot: true,
        ..glob::MatchOptions::new()
    };
    let mut names = files.names(folder)?;
    names.retain(|name| pattern.matches_with(name, options));
    names.sort();
    let stroke = if folder.is_empty() { "" } else { "/" };
    let whole = names.iter().map(|name| format!("{folder}{stroke}{name}"));
    Ok(whole.collect())
}
