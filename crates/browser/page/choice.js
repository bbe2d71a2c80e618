// Which mission is flown: chosen above the map, kept in the link.

const PACE = "2";

const hexadecimal = (bytes) => [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");

function make(tag, properties = {}, ...children) {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
}

/** The planners of a link: "mdp,greedy@12" is mdp from the start and greedy from decision 12 on. */
export function turnovers(text) {
  return text.split(",").filter(Boolean).map((word) => {
    const [planner, from = "0"] = word.split("@");
    return { from: Number(from), planner };
  });
}

/** The same of what was flown. */
export function planners(leaders) {
  return leaders.map(({ planner, from }) => (from > 0 ? `${planner}@${from}` : planner)).join(",");
}

/** The form with which a mission is chosen. */
export class Choice {
  constructor({ ask, leaders }) {
    this.ask = ask;
    this.leaders = leaders;
    this.ground = null;
    const select = (name) => make("select", { name });
    this.scenario = select("scenario");
    this.profile = select("profile");
    this.dynamics = select("dynamics");
    this.planner = select("planner");
    this.seed = make("input", { name: "seed", type: "number", min: 0, step: 1, value: 1 });
    this.file = make("input", { type: "file", accept: ".tif,.tiff,.asc", hidden: true });
    const open = make("button", { type: "button", textContent: "Elevation model", title: "Fly over a GeoTIFF or ESRI ASCII grid; or drop it on the page" });
    const again = make("button", { type: "submit", textContent: "Again", title: "Fly from the start" });
    const link = make("button", { type: "button", textContent: "Link", title: "Copy a link to this mission at this hop" });
    this.answer = make("output", { id: "asked" });
    this.answer.setAttribute("role", "status");
    const label = (text, field) => make("label", {}, text, field);
    this.form = make("form", { id: "choice" }, label("scenario", this.scenario), label("profile", this.profile), label("dynamics", this.dynamics), label("seed", this.seed),
      label("planner", this.planner), again, open, link, this.file, this.answer);
    this.form.setAttribute("aria-label", "Mission to fly");
    document.querySelector("header").append(this.form);

    open.addEventListener("click", () => this.file.click());
    link.addEventListener("click", () => this.share());
    this.file.addEventListener("change", () => this.file.files[0] && this.take(this.file.files[0]));
    for (const field of [this.scenario, this.profile, this.dynamics, this.seed]) field.addEventListener("change", () => this.fly());
    this.planner.addEventListener("change", () => this.handOver());
    // Keys of the page are none while a form is filled in.
    this.form.addEventListener("keydown", (event) => event.stopPropagation());
    this.form.addEventListener("submit", (event) => { event.preventDefault(); this.fly(); });
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      if (event.dataTransfer.files[0]) this.take(event.dataTransfer.files[0]);
    });
    addEventListener("hashchange", () => this.fromLink());
  }

  tell(text) {
    this.answer.textContent = text;
    this.answer.title = text;
  }

  /** Fills the form and flies what the link says. */
  async begin() {
    const { scenarios, profiles, dynamics } = await this.ask("choices");
    this.needsGround = new Set(scenarios.filter((one) => one.needs_ground).map(({ name }) => name));
    this.scenario.replaceChildren(...scenarios.map(({ name, is }) => make("option", { value: name, textContent: name, title: is })));
    for (const [field, names] of [[this.profile, profiles], [this.dynamics, dynamics]]) {
      field.replaceChildren(make("option", { value: "", textContent: "as the scenario says" }), ...names.map((name) => make("option", { value: name, textContent: name })));
    }
    await this.fromLink();
  }

  async fromLink() {
    const link = new URLSearchParams(location.hash.slice(1));
    const known = [...this.scenario.options].some(({ value }) => value === link.get("scenario"));
    if (link.get("scenario") && !known && link.get("scenario") !== "elevation model") this.tell(`there is no scenario ${link.get("scenario")}`);
    if (known) this.scenario.value = link.get("scenario");
    for (const field of [this.profile, this.dynamics]) {
      field.value = link.get(field.name) ?? "";
      if (field.selectedIndex < 0) field.value = "";
    }
    this.seed.value = link.get("seed") ?? "1";
    const hop = Number.parseInt(link.get("hop"), 10);
    const missing = link.get("dem") && !this.ground ? link.get("dem") : null;
    await this.fly(turnovers(link.get("planner") ?? ""), hop >= 0 ? hop : null, link.get("pace"));
    if (missing) this.tell(`this link is of the elevation model ${missing}: drop that file on the page`);
  }

  /** Flies what the form says from the start. */
  async fly(turnovers = null, hop = null, pace = null) {
    const own = this.scenario.value === "elevation model";
    const over = own || this.needsGround.has(this.scenario.value);
    if (over && !this.ground) {
      this.tell(`${this.scenario.value} needs an elevation model: drop a GeoTIFF or an ESRI ASCII grid on the page`);
      return;
    }
    const started = turnovers ?? (this.planner.value && !over ? [{ from: 0, planner: this.planner.value }] : []);
    const request = {
      scenario: own ? null : this.scenario.value, seed: Number(this.seed.value), profile: this.profile.value || null,
      dynamics: this.dynamics.value || null, planners: started, pace: hop === null ? pace ?? PACE : "max", run: hexadecimal(crypto.getRandomValues(new Uint8Array(16))), dem: over ? this.ground : null,
    };
    // At the hop of the link the mission waits; from there it goes on at this pace.
    const waits = { until: hop, pace: pace ?? PACE };
    try {
      let begun;
      try {
        begun = await this.ask("begin", { request, ...waits });
      } catch (error) {
        // Another scenario may need another planner than the one before.
        if (turnovers) throw error;
        begun = await this.ask("begin", { request: { ...request, planners: [] }, ...waits });
      }
      this.tell(begun.warnings.join("; "));
      const chosen = started.at(-1)?.planner;
      this.planner.replaceChildren(...begun.planners.map((name) => make("option", { value: name, textContent: name })));
      if (begun.planners.includes(chosen)) this.planner.value = chosen;
      this.remember(started.map(({ planner, from }) => ({ planner, from })), hop);
    } catch (error) {
      this.tell(error.message);
    }
  }

  /** Another planner takes command, from the next decision on that nobody has commanded yet. */
  async handOver() {
    try {
      if (await this.ask("hand_over", { planner: this.planner.value })) this.tell("");
      else await this.fly();
    } catch (error) {
      this.tell(error.message);
    }
  }

  /** An elevation model becomes the ground. */
  async take(file) {
    await this.ask("ground", { bytes: await file.arrayBuffer() });
    this.ground = file.name;
    if (!this.needsGround.has(this.scenario.value)) {
      if (![...this.scenario.options].some(({ value }) => value === "elevation model")) {
        this.scenario.append(make("option", { value: "elevation model", textContent: "elevation model" }));
      }
      this.scenario.value = "elevation model";
    }
    await this.fly();
  }

  /** The link of the mission, into the address. */
  remember(leaders, hop) {
    const link = new URLSearchParams({ scenario: this.scenario.value, seed: this.seed.value });
    for (const field of [this.profile, this.dynamics]) {
      if (field.value) link.set(field.name, field.value);
    }
    if (leaders.length > 0) link.set("planner", planners(leaders));
    if (hop !== null) link.set("hop", hop);
    if (this.ground && (this.scenario.value === "elevation model" || this.needsGround.has(this.scenario.value))) link.set("dem", this.ground);
    history.replaceState(null, "", `#${link.toString().replaceAll("%2C", ",").replaceAll("%40", "@")}`);
  }

  /** Copies the link of what is shown. */
  async share() {
    const robots = new Set(this.leaders.map(({ robot }) => robot ?? 0));
    this.remember(robots.size > 1 ? [] : this.leaders, Number(document.getElementById("moment").value));
    try {
      await navigator.clipboard.writeText(location.href);
      this.tell("the link is copied");
    } catch {
      this.tell("the link is in the address bar");
    }
  }
}
