//! Processes that answer orders, each at its own socket, and of which copies can be made.
//!
//! A frame is its length and so many bytes. A length of 0 that comes with one end of a new socket asks for a copy, which answers there. Whoever finds
//! nobody at the other end leaves: when the process that asks ends, however it does, none of these is left.
#![allow(unsafe_code)]

use std::io::{BufReader, Error, ErrorKind, IoSlice, IoSliceMut, Read, Write};
use std::mem::MaybeUninit;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::sync::Mutex;

use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer, SendAncillaryMessage, SendFlags,
    recvmsg, sendmsg,
};
use rustix::process::{WaitOptions, wait};

/// Where a process that answers is asked: none in the one that asks.
static OWN: Mutex<Option<UnixStream>> = Mutex::new(None);

/// The end at which a process is asked.
#[derive(Debug)]
pub(crate) struct Process(BufReader<UnixStream>);

impl Process {
    /// A process that does this.
    pub(crate) fn start(answers: fn() -> !) -> Result<Self, Error> {
        let (ours, theirs) = UnixStream::pair()?;
        if fork()? {
            drop(ours);
            *OWN.lock().expect("nobody else is here") = Some(theirs);
            answers()
        }
        Ok(Self(BufReader::new(ours)))
    }

    /// A copy of it as it is now, between two orders.
    pub(crate) fn copy(&self) -> Result<Self, Error> {
        let (ours, theirs) = UnixStream::pair()?;
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut with = SendAncillaryBuffer::new(&mut space);
        let end = [theirs.as_fd()];
        with.push(SendAncillaryMessage::ScmRights(&end));
        sendmsg(self.0.get_ref(), &[IoSlice::new(&[0; 4])], &mut with, SendFlags::empty())?;
        Ok(Self(BufReader::new(ours)))
    }

    pub(crate) fn tell(&mut self, order: &[u8]) -> Result<(), Error> {
        send(self.0.get_mut(), order)
    }

    pub(crate) fn hear(&mut self) -> Result<Vec<u8>, Error> {
        let mut length = [0; 4];
        self.0.read_exact(&mut length)?;
        let mut bytes = vec![0; u32::from_le_bytes(length) as usize];
        self.0.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

/// The next order to this process.
pub(crate) fn order() -> Vec<u8> {
    next().unwrap_or_else(|_| leave())
}

fn next() -> Result<Vec<u8>, Error> {
    let mut own = OWN.lock().expect("nobody else is here");
    loop {
        let stream = own.as_mut().ok_or(ErrorKind::NotConnected)?;
        // Most frames are here at once: there is never more than one on its way.
        let mut here = [0; 1024];
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut with = RecvAncillaryBuffer::new(&mut space);
        let came = recvmsg(&*stream, &mut [IoSliceMut::new(&mut here)], &mut with, RecvFlags::CMSG_CLOEXEC)?.bytes;
        let (length, begin) = here[..came].split_first_chunk().ok_or(ErrorKind::UnexpectedEof)?;
        let mut ends = with.drain().filter_map(|message| match message {
            RecvAncillaryMessage::ScmRights(ends) => Some(ends),
            _ => None,
        });
        let Some(end) = ends.next().and_then(|mut ends| ends.next()) else {
            let mut bytes = begin.to_vec();
            bytes.resize(u32::from_le_bytes(*length) as usize, 0);
            stream.read_exact(&mut bytes[begin.len()..])?;
            return Ok(bytes);
        };
        // Copies that have left.
        while matches!(wait(WaitOptions::NOHANG), Ok(Some(_))) {}
        // Without one, the end is closed: who asked for it sees that.
        if fork().unwrap_or(false) {
            *own = Some(end.into());
        }
    }
}

/// Answers an order.
pub(crate) fn answer(bytes: &[u8]) {
    let mut own = OWN.lock().expect("nobody else is here");
    own.as_mut().and_then(|stream| send(stream, bytes).ok()).unwrap_or_else(|| leave());
}

fn send(stream: &mut UnixStream, bytes: &[u8]) -> Result<(), Error> {
    stream.write_all(&[&(bytes.len() as u32).to_le_bytes(), bytes].concat())
}

/// Whether this is the copy.
fn fork() -> Result<bool, Error> {
    // SAFETY: `fork` asks nothing of its caller. Its copy has this thread alone, so it must not wait for what another held at this instant. The allocator
    // comes unlocked out of glibc's `fork`. The first copy is made where other tests run: all that it does is to read its socket, to allocate and to run a
    // board, for which none of those holds a lock; it never prints (a panic goes to the socket), unwinds or looks at the environment. Every later one is
    // made by the emulator's thread, while the only other waits for that one to end.
    match unsafe { libc::fork() } {
        -1 => Err(Error::last_os_error()),
        copy => Ok(copy == 0),
    }
}

/// Ends this process.
pub(crate) fn leave() -> ! {
    // SAFETY: `_exit` asks nothing of its caller. What a process does at its end, such as to write out what it was about to print, is the first one's.
    unsafe { libc::_exit(0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_is_asked_no_more_leaves() {
        fn echoes() -> ! {
            loop {
                answer(&order());
            }
        }
        // Each has the other end as long as it is there.
        let (mut end, theirs) = UnixStream::pair().expect("two ends");
        let mut first = Process::start(echoes).expect("a process");
        drop(theirs);
        let mut copy = first.copy().expect("a copy");
        let echo = |process: &mut Process, text: &[u8]| {
            process.tell(text).expect("it is there");
            assert_eq!(process.hear().expect("it is there"), text);
        };
        echo(&mut first, b"first");
        echo(&mut copy, b"copy");
        drop(first);
        echo(&mut copy, b"copy, alone");
        drop(copy);
        end.set_read_timeout(Some(std::time::Duration::from_secs(60))).expect("a time");
        assert_eq!(end.read(&mut [0]).expect("in time"), 0);
    }

    #[test]
    fn one_that_has_left_is_an_error() {
        fn leaves() -> ! {
            order();
            leave()
        }
        let mut process = Process::start(leaves).expect("a process");
        process.tell(b"leave").expect("it is there");
        assert_eq!(process.hear().expect_err("it has left").kind(), ErrorKind::UnexpectedEof);
        assert!(process.copy().and_then(|mut copy| copy.hear()).is_err());
    }
}
