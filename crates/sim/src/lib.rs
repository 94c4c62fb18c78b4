//! The session: a machine, a part program, the whole chain, the answer.

pub mod machine;
pub mod results;
