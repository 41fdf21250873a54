//! A scene in a browser, which follows the scene's file.

mod derivation_key;
mod feed;
mod server;
mod session;
mod watch;
mod write_back;

pub(crate) use feed::Feed;
pub(crate) use server::Server;
pub(crate) use session::Session;
