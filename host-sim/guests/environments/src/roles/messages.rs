//! What a role says, declared once: the layout of each message as the payload of an event, both ways.

/// What a role says, as payloads of events: kind and length of each message, and its fields with their offsets and meanings. What
/// no field takes is 0. `about 1` has the number of the object at offset 2, `about 0` has none. Flags stand in byte 1; what an
/// `Option` holds follows at the end. Of what is `flow` the newest counts; the rest is to arrive.
macro_rules! messages {
    (
        $(#[$meta:meta])*
        pub enum $Name:ident($message:literal, code $code:literal, about $objects:literal $(, flow $($Flow:ident)+)?) {
            $(
                $(#[$each:meta])+
                $Variant:ident = $kind:literal, $len:literal bytes $(:
                    $($offset:literal => $field:ident: $ty:ty, $doc:literal;)+
                    $(flags $($flag:ident: $flag_ty:ty, $flag_doc:literal;)+)?
                )?
            )+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum $Name {
            $($(#[$each])+ $Variant $({
                $(#[doc = $doc] $field: $ty,)+
                $($(#[doc = $flag_doc] $flag: $flag_ty,)+)?
            })?,)+
        }

        $($(const _: () = {
            let mut _end = if $objects == 0 { 1 } else { 4 };
            $(_end = { assert!(_end <= $offset, "fields overlap"); $offset + <$ty as cohold_protocol::bytes::Field>::LEN };)+
            assert!(_end <= $len, "a field is beyond the end");
        };)?)+

        impl crate::roles::Carried for $Name {
            const CODE: u16 = $code;

            fn event(&self, object: u16) -> Result<cohold_protocol::wire::Event, cohold_protocol::wire::Error> {
                let mut bytes = [0; cohold_protocol::wire::Event::MAX_PAYLOAD];
                let mut writer = cohold_protocol::bytes::Writer::new(&mut bytes, $message);
                match self {
                    $(Self::$Variant $({ $($field,)+ $($($flag,)+)? })? => {
                        writer.bytes(&[$kind]);
                        $($(writer.put(&cohold_protocol::bytes::byte_of(&[$(cohold_protocol::bytes::Flag::is_set($flag)),+]));)?)?
                        if $objects != 0 {
                            writer.zeros_to(2);
                            writer.put(&object);
                        }
                        $($(
                            writer.zeros_to($offset);
                            writer.put($field);
                        )+)?
                        writer.zeros_to($len);
                        $($($(cohold_protocol::bytes::Flag::write($flag, &mut writer);)+)?)?
                    })+
                }
                let len = writer.end()?;
                cohold_protocol::wire::Event::new($code, bytes.get(..len).unwrap_or(&[]))
            }

            fn parse(event: &cohold_protocol::wire::Event) -> Result<(u16, Self), cohold_protocol::wire::Error> {
                let bytes = event.payload();
                if event.code != $code {
                    return Err(cohold_protocol::wire::Error::OutOfRange { message: $message, field: "code" });
                }
                let kind = bytes.first().copied().unwrap_or(0);
                match kind {
                    $($kind => {
                        let _len = $len;
                        $($(
                            let mut _bits = bytes.get(1).copied().unwrap_or(0);
                            $(
                                let $flag = _bits & 1 == 1;
                                let _len = if $flag { _len + <$flag_ty as cohold_protocol::bytes::Flag>::TAIL } else { _len };
                                _bits >>= 1;
                            )+
                            if _bits != 0 {
                                return Err(cohold_protocol::wire::Error::Reserved($message));
                            }
                        )?)?
                        let mut reader = cohold_protocol::bytes::Reader::exact(bytes, $message, _len)?;
                        reader.kind($kind)?;
                        $($($(let _ = $flag;)+ reader.get::<u8>()?;)?)?
                        let object = if $objects != 0 {
                            reader.zeros_to(2)?;
                            reader.get()?
                        } else {
                            0
                        };
                        $($(
                            reader.zeros_to($offset)?;
                            let $field: $ty = reader.get()?;
                        )+)?
                        reader.zeros_to($len)?;
                        $($($(let $flag = <$flag_ty as cohold_protocol::bytes::Flag>::read($flag, &mut reader)?;)+)?)?
                        Ok((object, Self::$Variant $({ $($field,)+ $($($flag,)+)? })?))
                    })+
                    kind => Err(cohold_protocol::wire::Error::UnknownKind(kind)),
                }
            }

            fn is_flow(&self) -> bool {
                false $(|| matches!(self, $(Self::$Flow { .. })|+))?
            }
        }
    };
}

pub(crate) use messages;
