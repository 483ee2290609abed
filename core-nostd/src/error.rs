//! One line per error: `Display` and `core::error::Error` for the small enums beside the calls.

macro_rules! messages {
    ($($t:ident { $($variant:ident => $text:literal,)* })*) => { $(
        impl core::fmt::Display for $t {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(match self { $(Self::$variant => $text,)* })
            }
        }
        impl core::error::Error for $t {}
    )* };
}

pub(crate) use messages;
