//! The only place of the library that reads files: programs, their subroutines, descriptions of machines,
//! where they stand. Without the feature `files` nothing is there, and whatever is read is refused.

#[cfg(not(feature = "files"))]
pub use none::*;
#[cfg(feature = "files")]
pub use system::*;

#[cfg(feature = "files")]
mod system {
    use std::io;
    use std::path::{Path, PathBuf};

    /// A file that is open to be read.
    pub use std::fs::File;

    /// Opens a file to be read.
    ///
    /// # Errors
    /// It cannot be opened.
    pub fn open(path: &Path) -> io::Result<File> {
        File::open(path)
    }

    /// The whole text of a file.
    ///
    /// # Errors
    /// It cannot be read, or is not UTF-8.
    pub fn text(path: &Path) -> io::Result<String> {
        std::fs::read_to_string(path)
    }

    /// Size of a file, bytes.
    ///
    /// # Errors
    /// It is not there, or is a folder.
    pub fn size(path: &Path) -> io::Result<u64> {
        let metadata = std::fs::metadata(path)?;
        // Opening a folder succeeds on some systems and fails only at the first read.
        if metadata.is_dir() {
            let why = "is a folder, not a part program";
            return Err(io::Error::new(io::ErrorKind::IsADirectory, why));
        }
        Ok(metadata.len())
    }

    /// The true path, without links and `..`.
    ///
    /// # Errors
    /// There is nothing at the path.
    pub fn resolved(path: &Path) -> io::Result<PathBuf> {
        path.canonicalize()
    }

    /// Names of the files in a folder, in no particular order; those that are no text are left out.
    ///
    /// # Errors
    /// There is no such folder, or it may not be looked into.
    pub fn names(folder: &Path) -> io::Result<Vec<String>> {
        // A path without a folder is beside the program that runs.
        let here = Path::new(".");
        let folder = if folder == Path::new("") {
            here
        } else {
            folder
        };
        let mut names = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?;
            if entry.path().is_file() {
                names.extend(entry.file_name().into_string());
            }
        }
        Ok(names)
    }

    /// Whether there is a file at the path.
    pub fn is_file(path: &Path) -> bool {
        path.is_file()
    }

    /// Whether there is a folder at the path.
    pub fn is_folder(path: &Path) -> bool {
        path.is_dir()
    }
}

#[cfg(not(feature = "files"))]
mod none {
    use std::io::{self, Read, Seek, SeekFrom};
    use std::path::{Path, PathBuf};

    /// A file that is open to be read, of which there is none.
    #[derive(Debug)]
    pub enum File {}

    impl Read for File {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            match *self {}
        }
    }

    impl Seek for File {
        fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
            match *self {}
        }
    }

    fn refused<T>() -> io::Result<T> {
        let why = "this build of the library reads no files; give the text instead";
        Err(io::Error::new(io::ErrorKind::Unsupported, why))
    }

    /// Refused.
    ///
    /// # Errors
    /// Always.
    pub fn open(_: &Path) -> io::Result<File> {
        refused()
    }

    /// Refused.
    ///
    /// # Errors
    /// Always.
    pub fn text(_: &Path) -> io::Result<String> {
        refused()
    }

    /// Refused.
    ///
    /// # Errors
    /// Always.
    pub fn size(_: &Path) -> io::Result<u64> {
        refused()
    }

    /// Refused.
    ///
    /// # Errors
    /// Always.
    pub fn resolved(_: &Path) -> io::Result<PathBuf> {
        refused()
    }

    /// Refused.
    ///
    /// # Errors
    /// Always.
    pub fn names(_: &Path) -> io::Result<Vec<String>> {
        refused()
    }

    /// Nothing is there.
    pub fn is_file(_: &Path) -> bool {
        false
    }

    /// Nothing is there.
    pub fn is_folder(_: &Path) -> bool {
        false
    }
}
