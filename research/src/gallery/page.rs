//! The page that shows the figures.

use std::fmt::Write as _;

use super::Figure;

/// The page in Markdown; the figures lie in `folder` beside it.
pub fn page(figures: &[Figure], folder: &str) -> String {
    let mut text = String::from(
        "# Gallery\n\n\
         The figures of the papers' experiments in our own hand. One command draws them all again, to the same\n\
         bytes, and this page with them:\n\n\
         ```sh\n\
         cargo run --release -p hopper-research -- gallery\n\
         ```\n\n\
         Lengths are in metres from the middle of the south-western cell, north is up. Brightness is height;\n\
         hatched ground has not been seen yet, though the true height shows through faintly; a grey veil is\n\
         sand. An arrow is the hop that the policy in force would make from its cell; its colours and those of\n\
         the route can be told apart by a colour-blind eye, and each direction and kind of hop has a form of its\n\
         own too.\n\n\
         The figures of rover and helicopter (Folsom et al. 2021, P21) and of coverage (Laîné & Yoshida 2019, P19) are those of\n\
         the built-in campaigns with the papers' numbers of runs. `hopper campaign run p21`, then\n\
         `hopper campaign report out/p21 --against paper --out out/p21-report`, draws them of any number of runs.\n",
    );
    for Figure { name, title, text: words, .. } in figures {
        let _ = write!(text, "\n## {title}\n\n{words}\n\n![{title}]({folder}/{name}.svg)\n");
    }
    text
}
