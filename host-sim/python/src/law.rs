//! A coordination law that is written in Python, for trying it out before it becomes a file in Rust.
//!
//! It has its name, its own keys and its gains as any law has, and whatever takes a scene takes it: runs, stability, sweeps, steps. Each
//! peer asks Python once a tick, which makes a run some ten times slower, and only one thread at a time gets an answer. It is
//! a law of explicit numbers: what it is given, its state and what it answers are tuples of floats, so that the analyser can see its state.

use std::sync::{LazyLock, PoisonError, RwLock};

use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Sends};
use cohold_core::num::{Configured, Motion, Scalar, StateVector};
use cohold_core::object::{Port, Solve};
use cohold_core::settings::{Allowed, Key, Refused, Settings, Value};
use cohold_sim::{Family, Laws, Scene};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::raised::Raised;
use crate::work::refused;

/// Most numbers of a law's state.
const MOST_NUMBERS: usize = 16;
/// Most keys that a law reads.
const MOST_READ: usize = 16;

/// A law and its methods.
struct Written {
    info: &'static LawInfo,
    reads: &'static [&'static str],
    start: Py<PyAny>,
    receive: Py<PyAny>,
    couple: Py<PyAny>,
    send: Py<PyAny>,
}

static WRITTEN: RwLock<Vec<Written>> = RwLock::new(Vec::new());
static LAWS: LazyLock<RwLock<Laws>> = LazyLock::new(|| RwLock::new(cohold_guest_laws::laws()));

/// The laws that a scene may name now.
pub(crate) fn laws() -> Laws {
    *LAWS.read().unwrap_or_else(PoisonError::into_inner)
}

/// The laws that are written in Python.
struct FromPython;

impl Family for FromPython {
    type Of<S: Scalar> = AskPython;
}

/// One of them, with the values of the keys that it reads.
#[derive(Clone, Copy, Debug)]
struct AskPython {
    at: usize,
    sends: Sends,
    values: [f64; MOST_READ],
    count: usize,
}

/// Its state.
#[derive(Clone, Copy, Debug)]
struct Numbers<S> {
    numbers: [S; MOST_NUMBERS],
    count: usize,
}

impl<S: Scalar> StateVector<S> for Numbers<S> {
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        self.numbers[..self.count].iter_mut().for_each(each);
    }
}

impl<S: Scalar> Numbers<S> {
    fn of(given: &[f64]) -> Self {
        let mut numbers = [S::ZERO; MOST_NUMBERS];
        numbers.iter_mut().zip(given).for_each(|(number, given)| *number = S::from_f64(*given));
        Self { numbers, count: given.len() }
    }

    fn tuple<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.numbers[..self.count].iter().map(|number| number.to_f64()))
    }
}

fn pair<'py, S: Scalar>(py: Python<'py>, motion: Motion<S>) -> PyResult<Bound<'py, PyTuple>> {
    (motion.position.to_f64(), motion.velocity.to_f64()).into_pyobject(py)
}

impl AskPython {
    /// What the method answers, as `read` takes it; none, and what was raised is kept, if it did not. Not asked once the call is to end.
    fn ask<T>(
        &self,
        method: fn(&Written) -> &Py<PyAny>,
        read: impl for<'py> FnOnce(Python<'py>, &Bound<'py, PyAny>, Bound<'py, PyTuple>) -> PyResult<T>,
    ) -> Option<T> {
        let answer = Python::attach(|py| {
            if !Raised::asks(py)? {
                return Ok(None);
            }
            // Nobody who waits for the interpreter holds the lock.
            let method = method(&WRITTEN.read().unwrap_or_else(PoisonError::into_inner)[self.at]).clone_ref(py);
            let values = PyTuple::new(py, &self.values[..self.count])?;
            read(py, method.bind(py), values).map(Some)
        });
        answer.map_err(Raised::put).ok().flatten()
    }

    fn packet<'py, S: Scalar>(&self, py: Python<'py>, packet: Packet<S>) -> PyResult<Bound<'py, PyTuple>> {
        match self.sends {
            Sends::Waves => (packet.wave.to_f64(),).into_pyobject(py),
            _ => pair(py, packet.motion),
        }
    }
}

/// What anything that can be gone through holds: a tuple, a list, an array.
fn items<'py>(given: &Bound<'py, PyAny>) -> PyResult<Vec<Bound<'py, PyAny>>> {
    given.try_iter()?.collect()
}

/// Numbers of Python or of NumPy.
fn numbers(given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    items(given)?.iter().map(|number| number.extract()).collect()
}

/// So many of them.
fn exactly<const N: usize>(given: &Bound<'_, PyAny>, what: &str) -> PyResult<[f64; N]> {
    let numbers = numbers(given)?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| refused(format!("{what} of {count} numbers is not allowed: it must be {N}")))
}

/// Numbers of a state, of which there may be so many.
fn state(given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let numbers = numbers(given)?;
    match numbers.len() {
        0..=MOST_NUMBERS => Ok(numbers),
        many => Err(refused(format!("a state of {many} numbers is not allowed: it must be 0 to {MOST_NUMBERS}"))),
    }
}

/// Python is asked for plain numbers, which lanes do not have.
impl Configured for AskPython {}

impl<S: Scalar> Law<S> for AskPython {
    const LAWS: &'static [LawInfo] = &[];
    type State = Numbers<S>;

    fn info(settings: &Settings) -> Option<&'static LawInfo> {
        laws().schema().law(settings)
    }

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let schema = laws().schema();
        let written = WRITTEN.read().unwrap_or_else(PoisonError::into_inner);
        let at = written.iter().position(|law| law.info.name == settings.coordination.comm);
        let at = at.ok_or(Refused {
            key: "coordination.comm",
            value: Value::Text(settings.coordination.comm),
            allowed: Allowed::Laws(schema.laws()),
            unit: "",
        })?;
        let mut values = [0.0; MOST_READ];
        for (value, key) in values.iter_mut().zip(written[at].reads) {
            *value = match schema.get(settings, key) {
                Some(Value::Number(number)) => number,
                Some(Value::Flag(flag)) => f64::from(u8::from(flag)),
                _ => f64::NAN,
            };
        }
        Ok(Self { at, sends: written[at].info.sends, values, count: written[at].reads.len() })
    }

    fn start(&self, local: Motion<S>) -> Numbers<S> {
        let answer = self.ask(|law| &law.start, |py, start, values| state(&start.call1((values, pair(py, local)?))?));
        Numbers::of(&answer.unwrap_or_default())
    }

    fn receive(&self, numbers: &mut Numbers<S>, packet: Packet<S>) {
        let answer = self.ask(
            |law| &law.receive,
            |py, receive, values| state(&receive.call1((values, numbers.tuple(py)?, self.packet(py, packet)?))?),
        );
        if let Some(answer) = answer {
            *numbers = Numbers::of(&answer);
        }
    }

    /// Of a copy that is moved by ports: a force that does not depend on how the copy moves.
    fn couple(&self, numbers: &mut Numbers<S>, seen: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        let answer = self.ask(
            |law| &law.couple,
            |py, couple, values| {
                let contact_n = seen.contact_force.to_f64();
                let arguments = (values, numbers.tuple(py)?, pair(py, seen.local)?, contact_n, seen.age_ticks);
                let answer = items(&couple.call1(arguments)?)?;
                let (numbers, force, desired, powers) = match answer.as_slice() {
                    [numbers, force, desired] => (numbers, force, desired, None),
                    [numbers, force, desired, into, out] => (numbers, force, desired, Some([into, out])),
                    other => {
                        let count = other.len();
                        let must = "state, force and desired, and of waves power in and out";
                        return Err(refused(format!("couple gave {count} things: they must be {must}")));
                    }
                };
                let (force, desired) = (force.extract::<f64>()?, exactly::<2>(desired, "a desired motion")?);
                let power = force * desired[1];
                let powers = match powers {
                    None => [power.max(0.0), (-power).max(0.0)],
                    Some([into, out]) => [into.extract()?, out.extract()?],
                };
                Ok((state(numbers)?, force, desired, powers))
            },
        );
        let Some((answer, force, [position, velocity], [power_in, power_out])) = answer else {
            // No number: the peer stops with a fault, as it does with any law that has none.
            return Coupled { force: S::from_f64(f64::NAN), ..Coupled::default() };
        };
        *numbers = Numbers::of(&answer);
        let force = S::from_f64(force);
        solve.velocity(Port::of_force(force));
        Coupled {
            desired: Motion { position: S::from_f64(position), velocity: S::from_f64(velocity) },
            force,
            power_in: S::from_f64(power_in),
            power_out: S::from_f64(power_out),
        }
    }

    fn send(&self, numbers: &Numbers<S>, local: Motion<S>) -> Packet<S> {
        let answer = self.ask(
            |law| &law.send,
            |py, send, values| {
                let answer = send.call1((values, numbers.tuple(py)?, pair(py, local)?))?;
                match self.sends {
                    Sends::Waves => exactly::<1>(&answer, "a packet of waves").map(|[wave]| [wave, 0.0]),
                    _ => exactly::<2>(&answer, "a packet of motion"),
                }
            },
        );
        let [first, second] = answer.unwrap_or_default().map(S::from_f64);
        match self.sends {
            Sends::Waves => Packet { wave: first, ..Packet::default() },
            _ => Packet { motion: Motion { position: first, velocity: second }, ..Packet::default() },
        }
    }
}

/// Makes a law that is written in Python known: every scene can name it from then on, for the life of the process.
///
/// One of the same name takes the place of that law, if what it declares is the same.
#[pyfunction]
pub(crate) fn add_law(law: &Bound<'_, PyAny>) -> PyResult<()> {
    let text = |name: &str| law.getattr(name)?.extract::<String>();
    let leak = |text: String| -> &'static str { text.leak() };
    let (name, sends) = (text("name")?, text("sends")?);
    let sends = match sends.as_str() {
        "motion" => Sends::Motion,
        "waves" => Sends::Waves,
        other => {
            return Err(refused(format!(
                "sends = \"{other}\" is not allowed: it must be one of \"motion\", \"waves\""
            )));
        }
    };
    let methods = ["start", "receive", "couple", "send"].map(|method| law.getattr(method).map(Bound::unbind));
    let [start, receive, couple, send] = methods;
    let reads: Vec<String> = law.getattr("reads")?.extract()?;
    if reads.len() > MOST_READ {
        return Err(refused(format!("{} keys are more than a law reads: {MOST_READ}", reads.len())));
    }
    let gains: Vec<String> = law.getattr("gains")?.extract()?;
    let mut keys = Vec::new();
    for (key, of) in law.getattr("keys")?.cast::<PyDict>()? {
        let (default, min, max, unit, meaning): (f64, f64, f64, String, String) = of.extract()?;
        let key: String = key.extract()?;
        if !(key.starts_with(&format!("{name}.")) && min <= default && default <= max) {
            let must = format!("a law's own key is {name}.…, its default between its ends");
            return Err(refused(format!("{key} = {default} from {min} to {max} is not allowed: {must}")));
        }
        keys.push(Key::number(leak(key), default, [min, max], leak(unit)).means(leak(meaning)));
    }
    let known = laws();
    let mut written = WRITTEN.write().unwrap_or_else(PoisonError::into_inner);
    let there = written.iter().position(|law| law.info.name == name);
    let own = |key: &String| keys.iter().any(|own| own.name == *key);
    let scene = Scene::new(known);
    if let Some(key) =
        reads.iter().find(|key| !own(key) && !matches!(scene.get(key), Some(Value::Number(_) | Value::Flag(_))))
    {
        return Err(refused(format!(
            "reads \"{key}\" is not allowed: it must be a key of a scene that is a number or a flag"
        )));
    }
    let leak_all =
        |all: Vec<String>| -> &'static [&'static str] { all.into_iter().map(leak).collect::<Vec<_>>().leak() };
    // What a law written for trying out promises, nobody has shown.
    let of = if sends == Sends::Waves { LawInfo::WAVES } else { LawInfo::MOTION };
    let law = LawInfo { name: leak(name.clone()), keys: keys.leak(), gains: leak_all(gains), ..of };
    let methods = |law: &'static LawInfo| -> PyResult<Written> {
        Ok(Written {
            info: law,
            reads: leak_all(reads),
            start: start?,
            receive: receive?,
            couple: couple?,
            send: send?,
        })
    };
    if let Some(at) = there {
        if *written[at].info != law {
            return Err(refused(format!("there is a law {name} already, with other keys: give this one another name")));
        }
        let law = written[at].info;
        written[at] = methods(law)?;
        return Ok(());
    }
    if known.all().iter().any(|known| known.name == name) {
        return Err(refused(format!("there is a law {name} already: give this one another name")));
    }
    let laws: &'static [LawInfo] = vec![law].leak();
    written.push(methods(&laws[0])?);
    *LAWS.write().unwrap_or_else(PoisonError::into_inner) = known.with_laws::<FromPython>(laws);
    Ok(())
}
