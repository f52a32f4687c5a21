//! Checks a face's indices before the loader follows them.

use super::lines::words;
use crate::scene::SceneError;
use crate::scene::mesh::bad;

/// Refuses the first index that no line of the file defines: 0, too large, or too far back.
///
/// The loader looks at indices only at the end of each object, and does not catch all of them.
pub(super) fn check_indices(path: &str, bytes: &[u8]) -> Result<(), SceneError> {
    const KINDS: [(&str, &str); 3] =
        [("v", "vertex"), ("vt", "texture coordinate"), ("vn", "normal")];
    let kind_of =
        |words: &[&str]| KINDS.iter().position(|(keyword, _)| words.first() == Some(keyword));
    let mut total = [0i64; 3];
    words(bytes).filter_map(|words| kind_of(&words)).for_each(|kind| total[kind] += 1);
    let mut so_far = [0i64; 3];
    for (line, words) in words(bytes).enumerate() {
        if let Some(kind) = kind_of(&words) {
            so_far[kind] += 1;
        }
        if !matches!(words.first(), Some(&("f" | "l"))) {
            continue;
        }
        for (kind, index) in words[1..].iter().flat_map(|word| word.split('/').take(3).enumerate())
        {
            let Ok(index) = index.parse::<i64>() else {
                continue;
            };
            if index == 0 || index > total[kind] || index < -so_far[kind] {
                let (name, total) = (KINDS[kind].1, total[kind]);
                return Err(bad(
                    path,
                    Some(line + 1),
                    format!("{name} index {index} is out of range, expected 1..={total}"),
                ));
            }
        }
    }
    Ok(())
}
