//! Files of subroutines in folders that are allowed, and nowhere else.

use crate::failure::Failure;
use lostmotion::gcode::{LoadedFile, SubroutineLoader};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest file of subroutines.
const MAX_BYTES: u64 = 16 << 20;
/// Endings that a file of a subroutine may have, in the order they are tried. Numbers are also
/// looked for with an O before them.
const ENDINGS: [&str; 4] = ["ngc", "nc", "tap", ""];

/// The folder of the part, then those asked for.
#[derive(Debug)]
pub(crate) struct Folders {
    /// As they are, with all links followed.
    folders: Vec<PathBuf>,
}

impl Folders {
    /// Folders that exist; that of the part is left out if the part is no file in one.
    pub(crate) fn new(part: &Path, more: &[PathBuf]) -> Result<Folders, Failure> {
        let own = match part.parent() {
            Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
            Some(parent) => parent,
            None => Path::new("."),
        };
        let mut folders: Vec<PathBuf> = if part.is_file() {
            own.canonicalize().into_iter().collect()
        } else {
            Vec::new()
        };
        for folder in more {
            let shown = folder.display();
            let found = folder.canonicalize().map_err(|error| {
                Failure::message(format!("cannot read the folder {shown}: {error}"))
            })?;
            if !found.is_dir() {
                return Err(Failure::message(format!("{shown} is not a folder")));
            }
            folders.push(found);
        }
        Ok(Folders { folders })
    }

    /// A file of a folder, if it lies in one that is allowed once all links are followed.
    fn read(&self, folder: &Path, name: &str) -> Result<Option<LoadedFile>, String> {
        let path = folder.join(name);
        let Ok(found) = path.canonicalize() else {
            return Ok(None);
        };
        let shown = path.display();
        if !self.folders.iter().any(|folder| found.starts_with(folder)) {
            return Err(format!(
                "{shown} leads out of the folders that are allowed, to {}",
                found.display()
            ));
        }
        if !found.is_file() {
            return Ok(None);
        }
        let failed = |error: std::io::Error| format!("cannot read {shown}: {error}");
        let file = std::fs::File::open(&found).map_err(failed)?;
        let mut text = Vec::new();
        file.take(MAX_BYTES + 1)
            .read_to_end(&mut text)
            .map_err(failed)?;
        if text.len() as u64 > MAX_BYTES {
            return Err(format!("{shown} has more than {MAX_BYTES} bytes"));
        }
        Ok(Some(LoadedFile {
            name: shown.to_string(),
            text,
        }))
    }
}

/// Whether a name can be that of a file in a folder, and nothing else.
fn is_plain(name: &str) -> bool {
    !name.is_empty()
        && name.len() <= 200
        && name
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b'.'))
}

impl SubroutineLoader for Folders {
    fn load(&self, name: &str) -> Result<Option<LoadedFile>, String> {
        if !is_plain(name) || name.starts_with('.') || name.contains("..") {
            return Err("its name has other characters than letters, digits, _, - and ., so that no file is looked for".to_owned());
        }
        let number = name.parse::<u32>().ok();
        let stems = [
            Some(name.to_owned()),
            number.map(|number| format!("o{number:04}")),
            number.map(|number| format!("O{number:04}")),
        ];
        for folder in &self.folders {
            for stem in stems.iter().flatten() {
                for ending in ENDINGS {
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

    fn folders() -> (tempfile::TempDir, Folders) {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        std::fs::create_dir(at("part")).unwrap();
        std::fs::create_dir(at("lib")).unwrap();
        std::fs::write(at("secret.ngc"), "o<secret> sub").unwrap();
        std::fs::write(at("part/main.ngc"), "M2").unwrap();
        std::fs::write(at("part/own.ngc"), "own").unwrap();
        std::fs::write(at("lib/own.ngc"), "lib").unwrap();
        std::fs::write(at("lib/O0100.nc"), "hundred").unwrap();
        let found = Folders::new(&at("part/main.ngc"), &[at("lib")]).unwrap();
        (root, found)
    }

    fn text(found: &Folders, name: &str) -> Option<Vec<u8>> {
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
            std::os::unix::fs::symlink(root.path().join(to), root.path().join(from)).unwrap()
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
            vec![b' '; MAX_BYTES as usize + 1],
        )
        .unwrap();
        assert!(found.load("big").unwrap_err().contains("more than"));
    }
}
