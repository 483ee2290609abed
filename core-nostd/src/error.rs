//! Small error enums beside the calls that return them. What a variant's doc says is what `Display` prints.

macro_rules! errors {
    ($($(#[$meta:meta])* pub enum $t:ident { $($(#[doc = $text:literal])+ $variant:ident,)* })+) => { $(
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[non_exhaustive]
        pub enum $t { $($(#[doc = $text])+ $variant,)* }

        impl core::fmt::Display for $t {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(match self { $(Self::$variant => concat!($($text),+),)* }.trim_ascii())
            }
        }
        impl core::error::Error for $t {}
    )+ };
}

pub(crate) use errors;
