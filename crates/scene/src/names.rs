//! The rules for names, and suggestions for mistyped ones.

/// The candidate most similar to `name`, if any is similar enough.
pub fn closest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = name.to_lowercase();
    let limit = (name.len() / 3).max(1);
    candidates
        .into_iter()
        .filter(|candidate| candidate.len().abs_diff(name.len()) <= limit)
        .map(|candidate| (strsim::osa_distance(&lower, &candidate.to_lowercase()), candidate))
        // Names of one letter are at distance one without being similar.
        .filter(|(distance, candidate)| *distance <= limit && *distance < name.len().max(candidate.len()))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// Help for an unknown name: the name that was probably meant, or other help.
pub fn suggestion<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
    otherwise: impl FnOnce() -> String,
) -> String {
    closest(name, candidates).map_or_else(otherwise, |near| format!("did you mean `{near}`?"))
}

/// Whether `name` can be a name: letters, digits and `_`, beginning with a letter.
pub fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// The name of a scene's struct: `quick-return` becomes `QuickReturn`.
pub fn struct_name(scene: &str) -> String {
    let words = scene.split(['-', '_']).filter(|w| !w.is_empty());
    words.map(|word| word[..1].to_uppercase() + &word[1..]).collect()
}

/// The name of a scene's module: `quick-return` becomes `quick_return`.
pub fn module_name(scene: &str) -> String {
    scene.to_lowercase().replace('-', "_")
}
