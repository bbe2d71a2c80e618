//! The description of all packets in XTCE 1.2 (OMG), which mission control software reads.
//!
//! A container holds both headers; one for each kind of packet extends it where the APID is its own. Cells, of which a
//! packet has any number, are one binary parameter, since not every reader of XTCE knows arrays; `docs/ground.md` says
//! what they consist of.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use contract::field::{Meaning, Number};

use crate::{Item, Kind};

/// Fields of the primary header, with their bits.
const PRIMARY: [(&str, u32, &str); 7] = [
    ("VERSION", 3, "Packet version number."),
    ("TYPE", 1, "0 for telemetry."),
    ("SEC_HDR_FLG", 1, "1: there is a secondary header."),
    ("PKT_APID", 11, "Which packet it is."),
    ("SEQ_FLGS", 2, "3: unsegmented."),
    ("SRC_SEQ_CTR", 14, "Packets of this APID so far, modulo 2^14."),
    ("PKT_LEN", 16, "Bytes after this field, less one."),
];

/// Fields of the secondary header before its time, with their bits.
const SECONDARY: [(&str, u32, &str); 5] = [
    ("PUS_VERSION", 4, "2: PUS-C."),
    ("TIME_STATUS", 4, "Always 0."),
    ("SERVICE", 8, "PUS service."),
    ("SUBTYPE", 8, "Subtype of the service."),
    ("MESSAGE_COUNT", 16, "As SRC_SEQ_CTR."),
];

/// Parameter types and parameters so far.
#[derive(Default)]
struct Document {
    types: String,
    named: BTreeSet<String>,
    parameters: String,
    containers: String,
}

/// The document. It depends on nothing but this build: `build` names it.
#[must_use]
pub fn document(build: &str) -> String {
    let mut document = Document::default();
    document.root();
    for kind in Kind::ALL {
        document.kind(*kind);
    }
    let Document { types, parameters, containers, .. } = document;
    let build = escaped(build);
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<xtce:SpaceSystem xmlns:xtce="http://www.omg.org/spec/XTCE/20180204" name="hopper" shortDescription="Telemetry of a Hopper mission">
  <xtce:Header version="{build}" date="2026-11-27" validationStatus="Unknown"/>
  <xtce:TelemetryMetaData>
    <xtce:ParameterTypeSet>
{types}    </xtce:ParameterTypeSet>
    <xtce:ParameterSet>
{parameters}    </xtce:ParameterSet>
    <xtce:ContainerSet>
{containers}    </xtce:ContainerSet>
  </xtce:TelemetryMetaData>
</xtce:SpaceSystem>
"#
    )
}

impl Document {
    fn root(&mut self) {
        let mut entries = String::new();
        let destination = [("DESTINATION", 16, "Always 0.")];
        for (name, bits, what) in PRIMARY.iter().chain(&SECONDARY).chain(&destination) {
            let named = self.unsigned(*bits);
            self.parameter(name, &named, what);
            entry(&mut entries, name);
        }
        self.types.push_str(concat!(
            "      <xtce:FloatParameterType name=\"mission_time\" sizeInBits=\"64\">\n",
            "        <xtce:UnitSet><xtce:Unit description=\"seconds\">s</xtce:Unit></xtce:UnitSet>\n",
            "        <xtce:IntegerDataEncoding sizeInBits=\"48\" encoding=\"unsigned\">\n",
            "          <xtce:DefaultCalibrator><xtce:PolynomialCalibrator>\n",
            "            <xtce:Term coefficient=\"0\" exponent=\"0\"/>\n",
            "            <xtce:Term coefficient=\"0.0000152587890625\" exponent=\"1\"/>\n",
            "          </xtce:PolynomialCalibrator></xtce:DefaultCalibrator>\n",
            "        </xtce:IntegerDataEncoding>\n",
            "      </xtce:FloatParameterType>\n"
        ));
        self.parameter("MISSION_TIME", "mission_time", "Since the mission began.");
        entry(&mut entries, "MISSION_TIME");
        self.types.push_str(concat!(
            "      <xtce:BinaryParameterType name=\"checksum\">\n",
            "        <xtce:BinaryDataEncoding><xtce:SizeInBits><xtce:FixedValue>16</xtce:FixedValue></xtce:SizeInBits>",
            "</xtce:BinaryDataEncoding>\n",
            "      </xtce:BinaryParameterType>\n"
        ));
        self.parameter("CHECKSUM", "checksum", "CRC-16-CCITT over all bytes before.");
        writeln!(
            self.containers,
            "      <xtce:SequenceContainer name=\"CCSDSPacket\" abstract=\"true\" shortDescription=\"Both headers\">\n        \
             <xtce:EntryList>\n{entries}        </xtce:EntryList>\n      </xtce:SequenceContainer>"
        )
        .expect("a string grows");
    }

    fn kind(&mut self, kind: Kind) {
        let body = kind.body();
        let mut entries = String::new();
        let prefix = kind.as_str().to_lowercase();
        if kind.structure().is_some() {
            let (name, named) = (format!("{prefix}_structure"), self.unsigned(8));
            self.parameter(&name, &named, "Structure of the housekeeping report.");
            entry(&mut entries, &name);
        }
        let fields = if body.is_counted { &body.header } else { &body.cell };
        for item in fields {
            let name = format!("{prefix}_{}", item.name);
            let named = self.type_of(&name, item);
            self.parameter(&name, &named, item.reason);
            entry(&mut entries, &name);
        }
        if body.is_counted {
            let (count, cells) = (format!("{prefix}_count"), format!("{prefix}_cells"));
            let named = self.unsigned(16);
            self.parameter(&count, &named, "Cells that follow.");
            writeln!(
                self.types,
                "      <xtce:BinaryParameterType name=\"{cells}\">\n        <xtce:BinaryDataEncoding><xtce:SizeInBits>\
                 <xtce:DynamicValue><xtce:ParameterInstanceRef parameterRef=\"{count}\"/>\
                 <xtce:LinearAdjustment slope=\"{}\" intercept=\"0\"/></xtce:DynamicValue>\
                 </xtce:SizeInBits></xtce:BinaryDataEncoding>\n      </xtce:BinaryParameterType>",
                8 * body.cell_bytes()
            )
            .expect("a string grows");
            self.parameter(
                &cells,
                &cells,
                &format!("Cells of {} bytes, one after another.", body.cell_bytes()),
            );
            entry(&mut entries, &count);
            entry(&mut entries, &cells);
        }
        entry(&mut entries, "CHECKSUM");
        writeln!(
            self.containers,
            "      <xtce:SequenceContainer name=\"{kind}\" shortDescription=\"{}\">\n        \
             <xtce:EntryList>\n{entries}        </xtce:EntryList>\n        \
             <xtce:BaseContainer containerRef=\"CCSDSPacket\">\n          <xtce:RestrictionCriteria>\
             <xtce:Comparison parameterRef=\"PKT_APID\" value=\"{}\" useCalibratedValue=\"false\"/></xtce:RestrictionCriteria>\n        \
             </xtce:BaseContainer>\n      </xtce:SequenceContainer>",
            escaped(kind.what()),
            kind.apid()
        )
        .expect("a string grows");
    }

    /// The name of the type of a parameter, which is added unless it is there.
    fn type_of(&mut self, parameter: &str, item: &Item) -> String {
        let bits = 8 * item.bytes();
        match (&item.meaning, item.number) {
            (Meaning::Codes(codes), _) => {
                let mut labels = String::new();
                for (code, label) in codes {
                    let label = escaped(label);
                    writeln!(labels, "          <xtce:Enumeration value=\"{code}\" label=\"{label}\"/>")
                        .expect("a string grows");
                }
                writeln!(
                    self.types,
                    "      <xtce:EnumeratedParameterType name=\"{parameter}\">\n        \
                     <xtce:IntegerDataEncoding sizeInBits=\"{bits}\" encoding=\"unsigned\"/>\n        \
                     <xtce:EnumerationList>\n{labels}        </xtce:EnumerationList>\n      </xtce:EnumeratedParameterType>"
                )
                .expect("a string grows");
                parameter.to_owned()
            }
            (Meaning::Text, Number::U8) if item.count > 1 => self.once(format!("text_{}", item.count), |name| {
                format!(
                    "      <xtce:StringParameterType name=\"{name}\">\n        <xtce:StringDataEncoding encoding=\"UTF-8\">\
                     <xtce:SizeInBits><xtce:Fixed><xtce:FixedValue>{bits}</xtce:FixedValue></xtce:Fixed>\
                     <xtce:TerminationChar>00</xtce:TerminationChar></xtce:SizeInBits></xtce:StringDataEncoding>\n      \
                     </xtce:StringParameterType>\n"
                )
            }),
            (_, Number::U8) if item.count > 1 => self.once(format!("bytes_{}", item.count), |name| {
                format!(
                    "      <xtce:BinaryParameterType name=\"{name}\">\n        <xtce:BinaryDataEncoding><xtce:SizeInBits>\
                     <xtce:FixedValue>{bits}</xtce:FixedValue></xtce:SizeInBits></xtce:BinaryDataEncoding>\n      \
                     </xtce:BinaryParameterType>\n"
                )
            }),
            (_, Number::F64) => self.once("f64".into(), |name| {
                format!(
                    "      <xtce:FloatParameterType name=\"{name}\" sizeInBits=\"64\">\n        \
                     <xtce:FloatDataEncoding sizeInBits=\"64\" encoding=\"IEEE754_1985\"/>\n      \
                     </xtce:FloatParameterType>\n"
                )
            }),
            (_, Number::I32) => self.once("i32".into(), |name| {
                format!(
                    "      <xtce:IntegerParameterType name=\"{name}\" signed=\"true\" sizeInBits=\"32\">\n        \
                     <xtce:IntegerDataEncoding sizeInBits=\"32\" encoding=\"twosComplement\"/>\n      \
                     </xtce:IntegerParameterType>\n"
                )
            }),
            (_, Number::U8 | Number::U16 | Number::U32 | Number::U64) => self.unsigned(bits as u32),
        }
    }

    fn unsigned(&mut self, bits: u32) -> String {
        self.once(format!("u{bits}"), |name| {
            let size = if bits > 32 { 64 } else { 32 };
            format!(
                "      <xtce:IntegerParameterType name=\"{name}\" signed=\"false\" sizeInBits=\"{size}\">\n        \
                 <xtce:IntegerDataEncoding sizeInBits=\"{bits}\" encoding=\"unsigned\"/>\n      \
                 </xtce:IntegerParameterType>\n"
            )
        })
    }

    /// Adds the type of that name unless it is there.
    fn once(&mut self, name: String, element: impl FnOnce(&str) -> String) -> String {
        if self.named.insert(name.clone()) {
            self.types.push_str(&element(&name));
        }
        name
    }

    fn parameter(&mut self, name: &str, named: &str, what: &str) {
        let what = escaped(what);
        writeln!(
            self.parameters,
            "      <xtce:Parameter name=\"{name}\" parameterTypeRef=\"{named}\" shortDescription=\"{what}\"/>"
        )
        .expect("a string grows");
    }
}

fn entry(entries: &mut String, name: &str) {
    writeln!(entries, "          <xtce:ParameterRefEntry parameterRef=\"{name}\"/>").expect("a string grows");
}

/// Text as the value of an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
