//! Tests of `src/batch.rs` from inside: `std` alone is the other end.

use std::time::Duration;

use super::*;

fn socket() -> UdpSocket {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(2))).unwrap();
    socket
}

/// Three batches and a few, of every length from none to the longest, to two ends in turns.
#[test]
fn each_arrives_whole_in_order_and_where_it_was_sent() {
    let (from, ends) = (socket(), [socket(), socket()]);
    let datagram = |number: usize| vec![number as u8; number * 16 % (ROOM + 1)];
    let mut going = OutgoingBatch::default();
    for number in 0..3 * MOST + 5 {
        going.add(ends[number % 2].local_addr().unwrap(), &datagram(number));
    }
    assert_eq!((going.send(&from), going.send(&from)), (0, 0));
    let mut came = [0; ROOM];
    for number in 0..3 * MOST + 5 {
        let (length, by) = ends[number % 2].recv_from(&mut came).unwrap();
        assert_eq!((&came[..length], by), (&datagram(number)[..], from.local_addr().unwrap()), "number {number}");
    }
    for end in ends {
        end.set_nonblocking(true).unwrap();
        assert!(end.recv_from(&mut came).is_err(), "nothing is sent twice");
    }
}

#[test]
fn what_came_is_taken_in_order_and_nobody_waits_for_more() {
    for any in ["127.0.0.1:0", "[::1]:0"] {
        let Ok(to) = UdpSocket::bind(any) else { continue };
        to.set_read_timeout(Some(Duration::from_secs(2))).unwrap();
        let senders = [(); 2].map(|()| UdpSocket::bind(any).unwrap());
        let mut came = ReceivedBatch::default();
        // Taken twice: what a header was left with by one call must not change the next.
        for count in [MOST + 3, 2] {
            for number in 0..count {
                senders[number % 2].send_to(&vec![number as u8; number], to.local_addr().unwrap()).unwrap();
            }
            let mut number = 0;
            while number < count {
                came.take(&to).unwrap();
                for (from, datagram) in came.each() {
                    let sender = senders[number % 2].local_addr().unwrap();
                    assert_eq!((from, &*datagram), (sender, &vec![number as u8; number][..]), "number {number}");
                    number += 1;
                }
            }
        }
        to.set_nonblocking(true).unwrap();
        assert_eq!(came.take(&to).unwrap_err().kind(), io::ErrorKind::WouldBlock);
        assert_eq!(came.each().len(), 0);
    }
}

/// One that the system refuses is counted and holds up none behind it.
#[test]
fn one_that_is_not_taken_does_not_hold_up_the_others() {
    let (from, to) = (socket(), socket());
    let mut going = OutgoingBatch::default();
    for (number, to) in
        [to.local_addr().unwrap(), "[::1]:9".parse().unwrap(), to.local_addr().unwrap()].into_iter().enumerate()
    {
        going.add(to, &[number as u8]);
    }
    assert_eq!(going.send(&from), 1);
    let mut came = [0; 8];
    let numbers = [(); 2].map(|()| (to.recv_from(&mut came).unwrap().0, came[0]));
    assert_eq!(numbers, [(1, 0), (1, 2)]);
}
