//! Files of subroutines in folders that are allowed and nowhere else.

use crate::files;
use lostmotion_gcode::{LoadedFile, SubroutineLoader};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest file of subroutines, bytes: it is held in memory. A choice, as for other texts.
const MAX_SUBROUTINE_BYTES: u64 = 16 << 20;
/// Endings that a file of a subroutine may have, in the order they are tried. Numbers are also
/// looked for with an O before them.
const SUBROUTINE_ENDINGS: [&str; 4] = ["ngc", "nc", "tap", ""];

/// Why a folder cannot be searched.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct FolderError(String);

/// The folder of the part, then those asked for: files of subroutines are read there and nowhere
/// else, whatever name a program asks for.
///
/// ```
/// use lostmotion_sim::SubroutineFolders;
/// use std::path::Path;
///
/// let error = SubroutineFolders::new(Path::new("part.ngc"), &["no/such/folder".into()]).unwrap_err();
/// assert!(error.to_string().starts_with("cannot read the folder no/such/folder"));
/// ```
#[derive(Debug)]
pub struct SubroutineFolders {
    /// As they are, with all links followed.
    folders: Vec<PathBuf>,
}

impl SubroutineFolders {
    /// Folders that exist. The part's own folder is left out where the part is not a file.
    ///
    /// # Errors
    /// One of the others is not there or no folder.
    pub fn new(part: &Path, more: &[PathBuf]) -> Result<SubroutineFolders, FolderError> {
        // The parent of a bare file name is the empty path, which cannot be resolved.
        let own = match part.parent() {
            Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
            Some(parent) => parent,
            None => Path::new("."),
        };
        // A part from stdin has no folder whose files it may call.
        let mut folders: Vec<PathBuf> = if files::is_file(part) {
            files::resolved(own).into_iter().collect()
        } else {
            Vec::new()
        };
        // Resolved once: whether a file lies inside is decided on true paths, without links and
        // `..`.
        for folder in more {
            let shown = folder.display();
            let found = files::resolved(folder)
                .map_err(|error| FolderError(format!("cannot read the folder {shown}: {error}")))?;
            if !files::is_folder(&found) {
                return Err(FolderError(format!("{shown} is not a folder")));
            }
            folders.push(found);
        }
        Ok(SubroutineFolders { folders })
    }

    /// A file of a folder, if it lies in one that is allowed once all links are followed.
    fn read(&self, folder: &Path, name: &str) -> Result<Option<LoadedFile>, String> {
        let path = folder.join(name);
        // A file that does not exist is no error: the next ending or folder may have it.
        let Ok(found) = files::resolved(&path) else {
            return Ok(None);
        };
        let shown = path.display();
        // After all links are followed: a program must not read files outside through a link.
        if !self.folders.iter().any(|folder| found.starts_with(folder)) {
            return Err(format!(
                "{shown} leads out of the folders that are allowed, to {}",
                found.display()
            ));
        }
        if !files::is_file(&found) {
            return Ok(None);
        }
        let failed = |error: std::io::Error| format!("cannot read {shown}: {error}");
        let file = files::open(&found).map_err(failed)?;
        let mut text = Vec::new();
        file.take(MAX_SUBROUTINE_BYTES + 1)
            .read_to_end(&mut text)
            .map_err(failed)?;
        if text.len() as u64 > MAX_SUBROUTINE_BYTES {
            return Err(format!(
                "{shown} has more than {MAX_SUBROUTINE_BYTES} bytes"
            ));
        }
        Ok(Some(LoadedFile {
            name: shown.to_string(),
            text,
        }))
    }
}

/// Whether a name can be that of a file in a folder, and nothing else.
fn is_plain(name: &str) -> bool {
    // Names up to 200 bytes leave room for an O and an ending within the 255 that file systems
    // allow.
    !name.is_empty()
        && name.len() <= 200
        && name
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b'.'))
}

impl SubroutineLoader for SubroutineFolders {
    fn load(&self, name: &str) -> Result<Option<LoadedFile>, String> {
        // The name comes from the part program, which need not be trusted: no path, no hidden file.
        if !is_plain(name) || name.starts_with('.') || name.contains("..") {
            return Err(
                "its name may only have letters, digits, _, - and ., so no file is looked for"
                    .to_owned(),
            );
        }
        // M98 P100 calls O0100: controls name such files with and without the O.
        let number = name.parse::<u32>().ok();
        let stems = [
            Some(name.to_owned()),
            number.map(|number| format!("o{number:04}")),
            number.map(|number| format!("O{number:04}")),
        ];
        // The first folder that has it wins: a part's own subroutines go before those of a library.
        for folder in &self.folders {
            for stem in stems.iter().flatten() {
                for ending in SUBROUTINE_ENDINGS {
                    let file = if ending.is_empty() {
                        stem.clone()
                    } else {
                        format!("{stem}.{ending}")
                    };
                    if let Some(found) = self.read(folder, &file)? {
                        return Ok(Some(found));
                    }
                }
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folders() -> (tempfile::TempDir, SubroutineFolders) {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        std::fs::create_dir(at("part")).unwrap();
        std::fs::create_dir(at("lib")).unwrap();
        std::fs::write(at("secret.ngc"), "o<secret> sub").unwrap();
        std::fs::write(at("part/main.ngc"), "M2").unwrap();
        std::fs::write(at("part/own.ngc"), "own").unwrap();
        std::fs::write(at("lib/own.ngc"), "lib").unwrap();
        std::fs::write(at("lib/O0100.nc"), "hundred").unwrap();
        let found = SubroutineFolders::new(&at("part/main.ngc"), &[at("lib")]).unwrap();
        (root, found)
    }

    fn text(found: &SubroutineFolders, name: &str) -> Option<Vec<u8>> {
        found.load(name).unwrap().map(|file| file.text)
    }

    #[test]
    fn the_part_s_folder_comes_first() {
        let (_root, found) = folders();
        assert_eq!(text(&found, "own").unwrap(), b"own");
        assert_eq!(text(&found, "100").unwrap(), b"hundred");
        assert_eq!(text(&found, "other"), None);
    }

    #[test]
    fn names_cannot_leave_the_folders() {
        let (_root, found) = folders();
        for name in [
            "../secret",
            "..",
            ".",
            "",
            "a/b",
            "a\\b",
            "/etc/passwd",
            "c:x",
            "se\0cret",
            ".hidden",
            "a..b",
        ] {
            assert!(found.load(name).is_err(), "{name:?}");
        }
        assert_eq!(text(&found, "secret"), None);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_only_within_the_folders() {
        let (root, found) = folders();
        let link = |to: &str, from: &str| {
            std::os::unix::fs::symlink(root.path().join(to), root.path().join(from)).unwrap();
        };
        link("secret.ngc", "part/secret.ngc");
        link("lib/own.ngc", "part/inner.ngc");
        assert!(found.load("secret").unwrap_err().contains("leads out"));
        assert_eq!(text(&found, "inner").unwrap(), b"lib");
    }

    #[test]
    fn files_have_a_largest_size() {
        let (root, found) = folders();
        std::fs::write(
            root.path().join("part/big.ngc"),
            vec![b' '; MAX_SUBROUTINE_BYTES as usize + 1],
        )
        .unwrap();
        assert!(found.load("big").unwrap_err().contains("more than"));
    }
}
