//! One module per command: the straight line from input to output.

pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod curve;
pub(crate) mod fit;
pub(crate) mod info;
pub(crate) mod limit;
pub(crate) mod refine;
pub(crate) mod render;
pub(crate) mod repair;
pub(crate) mod streamline;
pub(crate) mod studio;
