//! Changes of a scene file by its page, which can be undone.

use std::io::{Error, Write};
use std::path::{Path, PathBuf};

use qrm_scene::files::write_atomic_with;
use qrm_scene::resolve;
use qrm_scene::source::read_text;

/// The largest number of changes that can be undone.
const MAX_CHANGES: usize = 200;

/// Changes a scene file.
pub(super) struct Editor {
    path: PathBuf,
    /// The changes that were made, and those that were undone, the next one last.
    done: Vec<Change>,
    undone: Vec<Change>,
}

/// A change of the file.
struct Change {
    before: String,
    after: String,
    /// Changes with the same name are one.
    gesture: Option<String>,
}

impl Editor {
    pub(super) fn new(path: PathBuf) -> Self {
        Self { path, done: Vec::new(), undone: Vec::new() }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Changes the text of the file. Changes of one gesture replace each other: each is made in the text before the
    /// gesture. The file is unchanged if the new text is no scene.
    pub(super) fn change<T>(
        &mut self,
        gesture: Option<&str>,
        change: impl FnOnce(&str) -> Result<(String, T), String>,
    ) -> Result<T, String> {
        let now = read_text(&self.path).map_err(|report| report.render(false))?;
        let is_same = |last: &&mut Change| gesture.is_some() && last.gesture.as_deref() == gesture && last.after == now;
        let last = self.done.last_mut().filter(is_same);
        let (after, made) = change(last.as_ref().map_or(&now, |last| &last.before))?;
        if after == now {
            return Ok(made);
        }
        write(&self.path, &now, &after)?;
        self.undone.clear();
        match last {
            Some(last) => last.after = after,
            None => self.done.push(Change { before: now, after, gesture: gesture.map(str::to_owned) }),
        }
        if self.done.len() > MAX_CHANGES {
            self.done.remove(0);
        }
        Ok(made)
    }

    /// Undoes the last change.
    pub(super) fn undo(&mut self) -> Result<(), String> {
        let last = self.done.last().ok_or_else(|| "there is nothing to undo".to_owned())?;
        write(&self.path, &last.after, &last.before)?;
        self.undone.extend(self.done.pop());
        Ok(())
    }

    /// Redoes the change that was undone last.
    pub(super) fn redo(&mut self) -> Result<(), String> {
        let last = self.undone.last().ok_or_else(|| "there is nothing to redo".to_owned())?;
        write(&self.path, &last.before, &last.after)?;
        self.done.extend(self.undone.pop());
        Ok(())
    }
}

/// Replaces the text of a file.
fn write(path: &Path, before: &str, after: &str) -> Result<(), String> {
    let name = path.display().to_string();
    let failed = |e: Error| format!("{name} cannot be written: {e}");
    resolve::read(&name, after).map_err(|report| report.render(false))?;
    // If the path is a link, its target is written.
    let file = path.canonicalize().map_err(failed)?;
    let permissions = std::fs::metadata(&file).map_err(failed)?.permissions();
    if permissions.readonly() {
        return Err(format!("{name} is write-protected"));
    }
    let write = |part: &mut std::fs::File| {
        part.write_all(after.as_bytes())?;
        part.set_permissions(permissions)?;
        let is_same = read_text(path).is_ok_and(|now| now == before);
        if is_same { Ok(()) } else { Err(Error::other("another program has saved it since; its text stays")) }
    };
    write_atomic_with(&file, write).map_err(failed)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// A scene with a number in its name.
    fn scene(number: u32) -> String {
        format!(
            "name = \"scene-{number}\"\nrun = {{ step = 1e-3, end_time = 1 }}\n[links]\nground = {{ points = {{}} }}\n"
        )
    }

    #[test]
    fn changes_are_undone_and_redone_unless_another_program_has_saved() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scene.toml");
        let text = || fs::read_to_string(&path).expect("a file");
        fs::write(&path, scene(0)).expect("written");
        let mut editor = Editor::new(path.clone());
        // Each change of a gesture is made in the text before the first.
        for number in [1, 2, 3] {
            let change = |before: &str| {
                assert_eq!(before, scene(0));
                Ok((scene(number), number))
            };
            assert_eq!(editor.change(Some("drag"), change), Ok(number));
        }
        assert_eq!(editor.change(None, |before| Ok((before.replace("scene-3", "scene-4"), ()))), Ok(()));
        assert_eq!(text(), scene(4));
        for expected in [3, 0] {
            assert!(editor.undo().is_ok());
            assert_eq!(text(), scene(expected));
        }
        assert_eq!(editor.undo(), Err("there is nothing to undo".to_owned()));
        for expected in [3, 4] {
            assert!(editor.redo().is_ok());
            assert_eq!(text(), scene(expected));
        }
        assert_eq!(editor.redo(), Err("there is nothing to redo".to_owned()));
        // What is no scene is not written, and what another program has saved stays.
        let refused = editor.change(None, |_| Ok(("name = 1".to_owned(), ())));
        assert!(refused.is_err() && text() == scene(4));
        fs::write(&path, scene(9)).expect("written");
        assert!(editor.undo().expect_err("refused").contains("another program has saved it"));
        assert_eq!(text(), scene(9));
    }
}
