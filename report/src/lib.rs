//! A run of the scheduler, or tables of results, as one HTML file that needs nothing else: no network, no other file.
//!
//! Plain data goes in ([`model`]), a page comes out ([`page`]). What a miss is made of is worked out here ([`blame`]),
//! because it follows from that data alone.

#![forbid(unsafe_code)]

mod bars;
pub mod blame;
mod chain_view;
mod escape;
mod histogram;
mod lanes_data;
pub mod model;
mod overview;
pub mod page;
pub mod results;
mod sections;
mod time;
mod window;

pub use time::time;
