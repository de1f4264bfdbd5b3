//! How names and bytes are written in JSON.

use std::fmt::Display;
use std::str::FromStr;

use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::Serializer;

/// What shows as its name and is found by it.
pub(super) mod by_name {
    use super::{Deserialize, Deserializer, Display, Error, FromStr, Serializer};

    pub(crate) fn serialize<S: Serializer>(
        value: &impl Display,
        out: S,
    ) -> Result<S::Ok, S::Error> {
        out.collect_str(value)
    }

    pub(crate) fn deserialize<'de, T, D>(from: D) -> Result<T, D::Error>
    where
        T: FromStr<Err: Display>,
        D: Deserializer<'de>,
    {
        let name = String::deserialize(from)?;
        name.parse().map_err(|e| D::Error::custom(format_args!("{name:?}: {e}")))
    }
}

/// One of a few values with names.
macro_rules! named {
    ($(#[$doc:meta])* $module:ident: $type:ident { $($name:literal = $value:ident),+ }) => {
        $(#[$doc])*
        pub(super) mod $module {
            use super::{Deserialize, Deserializer, Error, Serializer};
            use fairform::$type;

            pub(crate) fn serialize<S: Serializer>(
                value: &$type,
                out: S,
            ) -> Result<S::Ok, S::Error> {
                out.serialize_str(match value { $($type::$value => $name),+ })
            }

            pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
                from: D,
            ) -> Result<$type, D::Error> {
                let name = String::deserialize(from)?;
                match name.as_str() {
                    $($name => Ok($type::$value),)+
                    _ => Err(D::Error::custom(format_args!(
                        "{name:?}: expected one of: {}", [$($name),+].join(", ")
                    ))),
                }
            }
        }
    };
}

named!(
    /// What becomes of corners.
    corners: Corners { "smooth" = Smooth, "sharp" = Sharp }
);
named!(
    /// What becomes of the boundary.
    border: Border { "bspline" = Bspline, "drop" = Drop, "none" = None }
);

/// Bytes as base64.
pub(super) mod base64 {
    use super::{Deserialize, Deserializer, Error, Serializer};
    use base64::Engine as _;
    use base64::prelude::BASE64_STANDARD;

    pub(crate) fn serialize<S: Serializer>(bytes: &[u8], out: S) -> Result<S::Ok, S::Error> {
        out.serialize_str(&BASE64_STANDARD.encode(bytes))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<u8>, D::Error> {
        let text = String::deserialize(from)?;
        BASE64_STANDARD.decode(text).map_err(|e| D::Error::custom(format_args!("no base64: {e}")))
    }
}
