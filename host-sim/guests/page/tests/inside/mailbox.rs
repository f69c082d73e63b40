use super::*;
use crate::environment::MOST as NUMBERS;

fn numbered(number: usize) -> Sample {
    [number as f32; NUMBERS]
}

#[test]
fn who_asks_gets_what_came_since() {
    let mut contents = Contents::new(Model::Follows);
    (0..KEPT + 100).for_each(|number| contents.put(numbered(number)));
    let since = |from: u32| {
        let (first, samples) = contents.since(from);
        (first, samples.map(|sample| sample[0]).collect::<Vec<_>>())
    };
    let last = (KEPT + 100) as u32;
    assert_eq!(since(last - 2), (last - 2, vec![(last - 2) as f32, (last - 1) as f32]));
    assert_eq!(since(last), (last, vec![]));
    // Who slept, and who has nothing, gets all that is kept.
    for from in [50, u32::MAX, last + 1] {
        let (first, samples) = since(from);
        assert_eq!((first, samples.len(), samples[0]), (100, KEPT, 100.0), "{from}");
    }
}

#[test]
fn a_stop_is_never_turned_away() {
    let mut contents = Contents::new(Model::Follows);
    (0..2 * MOST).for_each(|_| contents.ask(Command::Start));
    contents.ask(Command::Stop);
    let all: Vec<_> = std::iter::from_fn(|| contents.next_command()).collect();
    assert_eq!(all.last(), Some(&Command::Stop));
}

#[test]
fn the_beat_does_not_wait() {
    let mailbox = Mailbox::new(Model::Follows);
    let held = mailbox.lock();
    assert!(mailbox.try_lock().is_none());
    drop(held);
    assert!(mailbox.try_lock().is_some());
}

#[test]
fn answers_go_to_who_asked_and_news_to_everybody_once() {
    let mut contents = Contents::new(Model::Follows);
    contents.answer(1, "one".into());
    contents.answer(2, "two".into());
    contents.tell("all".into());
    assert_eq!((contents.answer_for(2).as_deref(), contents.answer_for(2)), (Some("two"), None));
    let mut edition = 0;
    assert_eq!(contents.announced_since(&mut edition), ["all"]);
    assert!(contents.announced_since(&mut edition).is_empty());
    // What holds is not lost under news, and who comes late gets both.
    contents.tell_news("path".into());
    contents.tell("other".into());
    assert_eq!(contents.announced_since(&mut edition), ["other", "path"]);
    contents.tell_news("another path".into());
    assert_eq!(contents.announced_since(&mut edition), ["another path"]);
    assert_eq!(contents.announced_since(&mut 0), ["other", "another path"]);
    (0..3 * MOST).for_each(|_| contents.answer(9, "unread".into()));
    assert!(contents.answers.len() <= MOST);
    // Whoever fetches nothing pushes out no other's answers, several of them neither.
    contents.answer(3, "mine".into());
    (0..3 * MOST as u64).for_each(|at| contents.answer(9 + at % 3, "unread".into()));
    assert_eq!((contents.answer_for(3).as_deref(), contents.answers.len()), (Some("mine"), MOST - 1));
}

/// Of two orders between two ticks the second is what becomes of both: before, a scene of two axes was set in a pair of one, which ended
/// the control loop, and one that came before another environment was shown instead of that.
#[test]
fn the_last_order_before_a_tick_holds() {
    let scene = |axes: u32| {
        let mut scene = Scene::default();
        (scene.peer.axis.count, scene.peer.axis.shared) = (axes, axes);
        Box::new(scene)
    };
    let wanted = |requests: [Request; 2]| {
        let mut contents = Contents::new(Model::Follows);
        requests.into_iter().for_each(|request| contents.want(request));
        let last = contents.take_wanted();
        assert!(contents.take_wanted().is_none());
        match last.expect("an order") {
            Request::Scene(scene) => (None, scene.peer.axis.shared),
            Request::Show(kind, scene) => (Some(kind), scene.peer.axis.shared),
        }
    };
    let (pair, other) = (EnvironmentKind::Pair, EnvironmentKind::BadNetwork);
    let cases = [
        ([Request::Show(pair, scene(1)), Request::Scene(scene(2))], (Some(EnvironmentKind::Plane), 2)),
        ([Request::Scene(scene(2)), Request::Show(other, scene(1))], (Some(other), 1)),
        ([Request::Show(pair, scene(1)), Request::Show(other, scene(1))], (Some(other), 1)),
        ([Request::Scene(scene(1)), Request::Scene(scene(3))], (None, 3)),
    ];
    for (requests, last) in cases {
        assert_eq!(wanted(requests), last);
    }
}
