//! Tools for part programs in G-code, built on the public interface of [`lostmotion_gcode`].
//!
//! | module | does |
//! |---|---|
//! | [`lint`] | warns of programs that run, but may not do what is meant |
//! | [`format`](mod@format) | rewrites the text in one style; what the program does stays the same |
//! | [`explain`] | says in words what a block does |
//! | [`document`] | holds the text of a program so that single blocks can be edited |
//! | [`writer`] | writes canonical operations as a plain program without variables and loops |

pub mod document;
pub mod explain;
pub mod format;
pub mod lint;
mod raw_lines;
pub mod writer;
