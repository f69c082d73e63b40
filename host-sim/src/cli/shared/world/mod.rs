//! `host-sim shared world`: a static world on servers and at clients.

mod crowd;
mod serve;
mod show;
mod stroke;
mod visit;

crate::cli::commands! {
    /// What is done with a world.
    World {
        /// A server over UDP: the whole world, or one region of it.
        Serve(serve::Serve),
        /// A client of one or several servers: downloads a world and feels it.
        Visit(visit::Visit),
        /// What a world holds; without one, every key of a world file.
        Show(show::Show),
        /// A hand strokes along an object of a world and pushes it about: force, depth at corners, energy.
        #[command(alias = "shape")]
        Stroke(stroke::Stroke),
        /// Very many clients at one server: how many it holds, and where it bends.
        Crowd(crowd::Crowd),
    }
}
