//! Several output files that belong together.

use super::file::Unfinished;
use crate::atomic::AtomicFile;
use crate::error::WriteError;
use std::path::{Path, PathBuf};

/// A folder of results.
///
/// Files are collected with [`OutputFolder::add`] once each is written; [`OutputFolder::commit`]
/// first brings all of them to the disk and only then renames them, one right after the other. A
/// failure before the renames leaves the folder as it was, and a folder made here is removed again.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Folders made for it, the innermost first.
    made: Vec<PathBuf>,
    unfinished: Vec<Unfinished>,
    done: Vec<AtomicFile>,
}

impl OutputFolder {
    /// Opens a folder, making it and its parents where they do not exist.
    ///
    /// # Errors
    /// The path is a file, or the folder cannot be made.
    pub fn create(path: impl AsRef<Path>) -> Result<OutputFolder, WriteError> {
        let path = path.as_ref().to_path_buf();
        // The innermost first: in this order empty folders can be removed again.
        let missing: Vec<PathBuf> = path
            .ancestors()
            .filter(|p| !p.as_os_str().is_empty())
            .take_while(|p| !p.exists())
            .map(Path::to_path_buf)
            .collect();
        if path.exists() && !path.is_dir() {
            return Err(WriteError::NotFolder { path });
        }
        let (unfinished, made) =
            Unfinished::folders(missing.iter().rev(), || std::fs::create_dir_all(&path));
        let folder = OutputFolder {
            made: missing,
            unfinished,
            done: Vec::new(),
            path,
        };
        made.map_err(|e| WriteError::io("create", &folder.path, e))?;
        Ok(folder)
    }

    /// The folder's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Starts a file in the folder.
    ///
    /// # Errors
    /// The name has a path in it, or the file cannot be created.
    pub fn file(&self, name: &str) -> Result<AtomicFile, WriteError> {
        let plain = Path::new(name).file_name().is_some_and(|n| n == name);
        if !plain {
            return Err(WriteError::BadName {
                name: name.to_owned(),
            });
        }
        AtomicFile::create(self.path.join(name))
    }

    /// Takes a written file, to be named together with the others.
    pub fn add(&mut self, file: AtomicFile) {
        self.done.push(file);
    }

    /// Gives all added files their names; returns their paths.
    ///
    /// # Errors
    /// A file cannot be completed (then none appears), or a rename fails (then the files after it
    /// do not appear).
    pub fn commit(mut self) -> Result<Vec<PathBuf>, WriteError> {
        for file in &mut self.done {
            // Whatever can fail (a full disk) fails before the first rename.
            file.complete()?;
        }
        let mut paths = Vec::with_capacity(self.done.len());
        // Only renames are left: should one fail all the same, the files named so far stay.
        for file in self.done.drain(..) {
            paths.push(file.path().to_path_buf());
            file.commit()?;
        }
        // There are results now: the folder stays, whatever drops it.
        self.made.clear();
        self.unfinished.clear();
        Ok(paths)
    }
}

impl Drop for OutputFolder {
    /// Removes folders that were made for files that never came. `remove_dir` refuses folders that
    /// hold anything.
    fn drop(&mut self) {
        self.done.clear();
        for folder in &self.made {
            // Another program has put something there: its parents cannot go either.
            if std::fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn files_appear_together() {
        let base = tempfile::tempdir().unwrap();
        let mut out = OutputFolder::create(base.path().join("a/b")).unwrap();
        for name in ["one.csv", "two.csv"] {
            let mut file = out.file(name).unwrap();
            file.write_all(name.as_bytes()).unwrap();
            out.add(file);
        }
        assert!(!base.path().join("a/b/one.csv").exists());
        assert_eq!(out.commit().unwrap().len(), 2);
        assert_eq!(
            std::fs::read_to_string(base.path().join("a/b/two.csv")).unwrap(),
            "two.csv"
        );
    }

    #[test]
    fn an_abandoned_folder_vanishes_with_its_files() {
        let base = tempfile::tempdir().unwrap();
        let mut out = OutputFolder::create(base.path().join("a/b")).unwrap();
        let file = out.file("one.csv").unwrap();
        out.add(file);
        drop(out);
        assert!(!base.path().join("a").exists());
        assert!(base.path().exists());
    }

    #[test]
    fn bad_places_are_refused() {
        let base = tempfile::tempdir().unwrap();
        std::fs::write(base.path().join("file"), "").unwrap();
        assert!(matches!(
            OutputFolder::create(base.path().join("file")),
            Err(WriteError::NotFolder { .. })
        ));
        let out = OutputFolder::create(base.path()).unwrap();
        assert!(matches!(out.file("../x"), Err(WriteError::BadName { .. })));
        assert!(matches!(out.file("x/"), Err(WriteError::BadName { .. })));
    }
}
