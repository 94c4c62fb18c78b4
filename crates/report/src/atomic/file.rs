//! One output file, and the list of those that are not finished.

use crate::error::WriteError;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

/// Buffer of a file, bytes: large enough that a plan's rows reach the disk in few calls. A choice.
const BUFFER_BYTES: usize = 1 << 18;

/// Where the bytes go until the file is complete.
#[derive(Debug)]
enum Target {
    /// A temporary file beside the final one.
    Temporary(BufWriter<NamedTempFile>, Unfinished),
    /// A pipe or device, which cannot be replaced and is written to directly.
    Special(BufWriter<File>),
}

/// A file that takes its final name only on [`AtomicFile::commit`].
///
/// A symbolic link is followed, so that the file it points to is replaced. Pipes and devices
/// (`/dev/null`) are written directly.
#[derive(Debug)]
pub struct AtomicFile {
    path: PathBuf,
    target: Target,
}

impl AtomicFile {
    /// Starts a file. Its folder has to exist.
    ///
    /// # Errors
    /// The path is a folder, or nothing can be created beside it.
    pub fn create(path: impl AsRef<Path>) -> Result<AtomicFile, WriteError> {
        let asked = path.as_ref();
        // Follows a link, so that its target is replaced and the link stays.
        let path = asked.canonicalize().unwrap_or_else(|_| asked.to_path_buf());
        let target = match path.metadata() {
            Ok(meta) if meta.is_dir() => {
                return Err(WriteError::IsFolder {
                    path: asked.to_path_buf(),
                });
            }
            // A pipe or device has no name to take over: it is written as it comes.
            Ok(meta) if !meta.is_file() => {
                let file = File::options()
                    .write(true)
                    .open(&path)
                    .map_err(|e| WriteError::io("open", asked, e))?;
                Target::Special(BufWriter::with_capacity(BUFFER_BYTES, file))
            }
            _ => {
                let (file, unfinished) = Unfinished::file(|| temporary_beside(&path))
                    .map_err(|e| WriteError::io("create", asked, without_path(&e)))?;
                Target::Temporary(BufWriter::with_capacity(BUFFER_BYTES, file), unfinished)
            }
        };
        Ok(AtomicFile { path, target })
    }

    /// The final path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Flushes everything to the disk without giving the file its name yet.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub(crate) fn complete(&mut self) -> Result<(), WriteError> {
        let result = match &mut self.target {
            Target::Temporary(writer, _) => writer
                .flush()
                // Without it a power cut after the rename could leave a file of length 0.
                .and_then(|()| writer.get_ref().as_file().sync_all()),
            Target::Special(writer) => writer.flush(),
        };
        result.map_err(|e| WriteError::io("write", &self.path, e))
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// The disk is full or gone, or the name cannot be taken; then nothing is left behind.
    pub fn commit(mut self) -> Result<(), WriteError> {
        self.complete()?;
        let AtomicFile { path, target } = self;
        if let Target::Temporary(writer, _unfinished) = target {
            let file = writer
                .into_inner()
                .map_err(|e| WriteError::io("write", &path, e.into_error()))?;
            file.persist(&path)
                .map_err(|e| WriteError::io("replace", &path, e.error))?;
        }
        Ok(())
    }
}

/// The error without the name of the temporary file, which the user has not chosen.
fn without_path(error: &std::io::Error) -> std::io::Error {
    match error.kind() {
        std::io::ErrorKind::NotFound => {
            std::io::Error::new(std::io::ErrorKind::NotFound, "its folder does not exist")
        }
        kind => kind.into(),
    }
}

/// A temporary file in the folder of `path`, with the permissions that an ordinary new file there
/// would get.
fn temporary_beside(path: &Path) -> std::io::Result<NamedTempFile> {
    // In the folder of the final file: a rename is atomic only within one file system.
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".lostmotion-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Of the file to be replaced; a new one gets what the umask leaves, not the 0600 of
        // temporary files.
        let mode = path
            .metadata()
            .map_or(0o666, |meta| meta.permissions().mode() & 0o777);
        builder.permissions(std::fs::Permissions::from_mode(mode));
        builder.tempfile_in(folder)
    }
    #[cfg(not(unix))]
    builder.tempfile_in(folder)
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match &mut self.target {
            Target::Temporary(writer, _) => writer.write(bytes),
            Target::Special(writer) => writer.write(bytes),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        match &mut self.target {
            Target::Temporary(writer, _) => writer.flush(),
            Target::Special(writer) => writer.flush(),
        }
    }
}

/// Temporary files, and folders that were made for files to come, by their number.
static UNFINISHED: Mutex<BTreeMap<u64, PathBuf>> = Mutex::new(BTreeMap::new());

fn unfinished() -> MutexGuard<'static, BTreeMap<u64, PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An entry in the list, as long as it lives.
#[derive(Debug)]
pub(super) struct Unfinished(u64);

impl Unfinished {
    /// Makes a file; `abandon` comes before or after, never between file and entry.
    pub(super) fn file(
        make: impl FnOnce() -> std::io::Result<NamedTempFile>,
    ) -> std::io::Result<(NamedTempFile, Unfinished)> {
        let mut all = unfinished();
        let file = make()?;
        let entry = Unfinished::enter(&mut all, file.path().to_path_buf());
        Ok((file, entry))
    }

    /// Makes folders, the outermost first, in the same way; those that were made are entered in any
    /// case.
    pub(super) fn folders<'a>(
        folders: impl Iterator<Item = &'a PathBuf>,
        make: impl FnOnce() -> std::io::Result<()>,
    ) -> (Vec<Unfinished>, std::io::Result<()>) {
        let mut all = unfinished();
        let entries = folders
            .map(|folder| Unfinished::enter(&mut all, folder.clone()))
            .collect();
        (entries, make())
    }

    fn enter(all: &mut BTreeMap<u64, PathBuf>, path: PathBuf) -> Unfinished {
        // Numbers rise with time: `abandon` removes the latest first.
        let number = all.last_key_value().map_or(0, |(last, _)| last + 1);
        all.insert(number, path);
        Unfinished(number)
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        unfinished().remove(&self.0);
    }
}

/// What [`abandon`] gives: as long as it lives no file begins.
#[derive(Debug)]
#[must_use = "a file that begins before the process ends is left behind"]
pub struct Abandoned {
    _list: MutexGuard<'static, BTreeMap<u64, PathBuf>>,
}

/// Removes every file that is being written, and the folders made for them, before a process ends
/// without dropping its values (a signal). Who begins or ends a file meanwhile waits until the answer
/// is dropped.
pub fn abandon() -> Abandoned {
    let mut all = unfinished();
    // The latest first: files, then the folders around them, the innermost first.
    while let Some((_, path)) = all.pop_last() {
        let _ = if path.is_dir() {
            std::fs::remove_dir(&path)
        } else {
            std::fs::remove_file(&path)
        };
    }
    Abandoned { _list: all }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_committed_file_is_whole_and_replaces_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.csv");
        std::fs::write(&path, "old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        file.commit().unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names(folder.path()), ["plan.csv"]);
    }

    #[test]
    fn a_dropped_file_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = AtomicFile::create(folder.path().join("plan.csv")).unwrap();
        file.write_all(&vec![b'x'; 1_000_000]).unwrap();
        assert_eq!(names(folder.path()).len(), 1);
        drop(file);
        assert_eq!(names(folder.path()), [""; 0]);
    }

    #[test]
    fn a_folder_and_a_missing_folder_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(
            AtomicFile::create(folder.path()),
            Err(WriteError::IsFolder { .. })
        ));
        assert!(matches!(
            AtomicFile::create(folder.path().join("no/plan.csv")),
            Err(WriteError::Io {
                action: "create",
                ..
            })
        ));
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_written_not_replaced_and_links_are_followed() {
        use std::os::unix::fs::FileTypeExt;
        let mut null = AtomicFile::create("/dev/null").unwrap();
        null.write_all(b"gone").unwrap();
        null.commit().unwrap();
        assert!(
            std::fs::metadata("/dev/null")
                .unwrap()
                .file_type()
                .is_char_device()
        );

        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("real"), "old").unwrap();
        std::os::unix::fs::symlink("real", folder.path().join("link")).unwrap();
        let mut file = AtomicFile::create(folder.path().join("link")).unwrap();
        file.write_all(b"new").unwrap();
        file.commit().unwrap();
        assert_eq!(
            std::fs::read_to_string(folder.path().join("real")).unwrap(),
            "new"
        );
        assert!(
            folder
                .path()
                .join("link")
                .symlink_metadata()
                .unwrap()
                .is_symlink()
        );
    }

    #[cfg(unix)]
    #[test]
    fn new_files_are_readable_as_usual() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("usual"), "").unwrap();
        AtomicFile::create(folder.path().join("ours"))
            .unwrap()
            .commit()
            .unwrap();
        let mode = |name: &str| {
            folder
                .path()
                .join(name)
                .metadata()
                .unwrap()
                .permissions()
                .mode()
        };
        assert_eq!(mode("ours"), mode("usual"));
    }
}
