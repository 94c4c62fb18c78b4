//! Where subroutines come from that the program itself does not define.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::Arc;

/// Gives the text of a file that holds a subroutine. All access to files is behind this trait.
pub trait SubroutineLoader: Debug + Send + Sync {
    /// The file of subroutine `name` (lower case, as in `o<name> call`, or the number of an M98),
    /// with the name to show for it; none if there is no such file.
    ///
    /// # Errors
    /// Why the file cannot be read.
    fn load(&self, name: &str) -> Result<Option<LoadedFile>, String>;
}

/// A file with subroutines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadedFile {
    /// Its name, for messages.
    pub name: String,
    /// What it contains.
    pub text: Vec<u8>,
}

/// The files of a run: index 0 of the list is file 1 of spans, file 0 being the program itself.
pub type SourceFiles = Vec<Arc<LoadedFile>>;

/// Files held in memory, by the name of their subroutine.
impl SubroutineLoader for BTreeMap<String, Vec<u8>> {
    fn load(&self, name: &str) -> Result<Option<LoadedFile>, String> {
        Ok(self.get(name).map(|text| LoadedFile {
            name: format!("{name}.ngc"),
            text: text.clone(),
        }))
    }
}
