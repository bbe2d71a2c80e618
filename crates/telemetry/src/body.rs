//! Bodies: wire types in big-endian byte order.

use bytemuck::Zeroable;
use contract::Payload;

use crate::error::PacketError;
use crate::layout::{Body, Item};

/// Appends the body of `message`.
pub fn encode<P: Payload>(layout: &Body, message: &P, bytes: &mut Vec<u8>) {
    write(&layout.header, bytemuck::bytes_of(&message.header()), bytes);
    let cells = message.cells();
    if layout.is_counted {
        let count = u16::try_from(cells).expect("a message has fewer cells than 2^16");
        bytes.extend(count.to_be_bytes());
    }
    for index in 0..cells {
        write(&layout.cell, bytemuck::bytes_of(&message.cell(index)), bytes);
    }
}

/// The message of a body, which has to be as long as its number of cells says; `kind` names it in the error.
pub fn decode<P: Payload>(kind: &'static str, layout: &Body, body: &[u8]) -> Result<P, PacketError> {
    let (head, cell) = (layout.head_bytes(), layout.cell_bytes());
    let wrong = |need| PacketError::Body { kind, need, got: body.len() };
    let (front, cells) = body.split_at_checked(head).ok_or_else(|| wrong(head + cell))?;
    let (front, count) = if layout.is_counted {
        let (front, count) = front.split_at(head - 2);
        (front, usize::from(u16::from_be_bytes([count[0], count[1]])))
    } else {
        (front, 1)
    };
    if cells.len() != count * cell {
        return Err(wrong(head + count * cell));
    }
    let mut header = P::Header::zeroed();
    read(&layout.header, front, bytemuck::bytes_of_mut(&mut header));
    let wires: Vec<P::Cell> = cells
        .chunks_exact(cell)
        .map(|chunk| {
            let mut wire = P::Cell::zeroed();
            read(&layout.cell, chunk, bytemuck::bytes_of_mut(&mut wire));
            wire
        })
        .collect();
    P::from_wire(&header, &wires).map_err(|refusal| PacketError::Refused { kind, refusal })
}

/// Appends the numbers of a wire type.
fn write(items: &[Item], wire: &[u8], bytes: &mut Vec<u8>) {
    for item in items {
        let native = &wire[item.offset..item.offset + item.bytes()];
        if cfg!(target_endian = "little") && item.count == 1 {
            bytes.extend(native.iter().rev());
        } else {
            bytes.extend(native);
        }
    }
}

/// Reads the numbers of a wire type from as many bytes as they take.
fn read(items: &[Item], mut bytes: &[u8], wire: &mut [u8]) {
    for item in items {
        let (number, rest) = bytes.split_at(item.bytes());
        let native = &mut wire[item.offset..item.offset + item.bytes()];
        native.copy_from_slice(number);
        if cfg!(target_endian = "little") && item.count == 1 {
            native.reverse();
        }
        bytes = rest;
    }
}
