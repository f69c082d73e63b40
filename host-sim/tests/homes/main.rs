//! Two homes, one link, as processes: on loopback in every run, and behind routers in network namespaces where the machine has them (`cargo xtask homes`).

mod lab;
mod loopback;
mod peers;
mod routers;
