//! Two homes, one link, as processes: on loopback in every run, and behind routers in network namespaces where the machine has them (`cargo xtask test --only homes`).

mod bridge;
#[path = "../suite/play/devtools.rs"]
#[expect(dead_code, reason = "two people need less of a browser than the page's own tests")]
mod devtools;
mod image;
mod lab;
mod loopback;
mod pages;
mod peers;
mod recipes;
mod routers;
