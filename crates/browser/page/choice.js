// Which mission is flown: chosen above the map, kept in the link.

const PACE = "2";

/** The parts of a link. */
const PARTS = ["scenario", "seed", "profile", "dynamics", "planner", "hop", "pace", "dem"];

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
    /** The file of the elevation model on the page, and the scenario that was chosen when it came. */
    this.ground = null;
    this.groundFor = null;
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
    this.needsGround = new Map(scenarios.filter(({ ground }) => ground).map(({ name, ground }) => [name, ground]));
    this.names = { profile: profiles, dynamics };
    this.scenario.replaceChildren(...scenarios.map(({ name, is }) => make("option", { value: name, textContent: name, title: is })));
    for (const [field, names] of [[this.profile, profiles], [this.dynamics, dynamics]]) {
      field.replaceChildren(make("option", { value: "", textContent: "as the scenario says" }), ...names.map((name) => make("option", { value: name, textContent: name })));
    }
    await this.fromLink();
  }

  async fromLink() {
    const link = new URLSearchParams(location.hash.slice(1));
    const wrong = [];
    // What a part of the link says if it is possible; what is wrong with it is told.
    const part = (name, otherwise, isPossible, need) => {
      const got = link.get(name);
      if (got === null || isPossible(got)) return got ?? otherwise;
      wrong.push(`${name} needs to be ${need}, got ${got}`);
      return otherwise;
    };
    const isNumber = (text) => /^\d{1,15}$/.test(text);
    for (const name of link.keys()) if (!PARTS.includes(name)) wrong.push(`a link has no part ${name}`);
    const scenarios = [...this.scenario.options].map(({ value }) => value);
    const scenario = part("scenario", this.scenario.value, (text) => text === "elevation model" || scenarios.includes(text), `one of ${scenarios.join(", ")}`);
    if (scenarios.includes(scenario)) this.scenario.value = scenario;
    for (const field of [this.profile, this.dynamics]) {
      const names = this.names[field.name];
      field.value = part(field.name, "", (text) => names.includes(text), `one of ${names.join(", ")}`);
    }
    this.seed.value = part("seed", "1", isNumber, "a number");
    const hop = part("hop", null, isNumber, "a number");
    const missing = link.get("dem") && !this.ground ? link.get("dem") : null;
    const asked = turnovers(link.get("planner") ?? "");
    const flown = await this.fly(asked, hop === null ? null : Number(hop), link.get("pace"));
    if (flown !== null && asked.length + (link.get("pace") ? 1 : 0) > 0 && !missing) {
      // Its planners or its pace are not possible: better the mission without them than none.
      wrong.push(flown);
      await this.fly([], hop === null ? null : Number(hop));
    }
    const said = wrong.length > 0 ? [`the link is wrong: ${wrong.join("; ")}`] : [];
    if (missing) said.push(`this link is of the elevation model ${missing}: drop that file on the page`);
    if (said.length > 0) this.tell(said.join("; "));
  }

  /** Flies what the form says from the start. Why it cannot, or null. */
  async fly(turnovers = null, hop = null, pace = null) {
    const refuse = (text) => { this.tell(text); return text; };
    const own = this.scenario.value === "elevation model";
    const over = own || this.needsGround.has(this.scenario.value);
    if (over && !this.ground) {
      const file = this.needsGround.get(this.scenario.value);
      return refuse(`${this.scenario.value} needs an elevation model: drop ${file ? `${file}, or another ` : "a "}GeoTIFF or ESRI ASCII grid on the page`);
    }
    const made = this.needsGround.get(this.scenario.value);
    if (made && this.ground !== made && this.groundFor !== this.scenario.value) {
      return refuse(`${this.scenario.value} is made for the elevation model ${made}, and the page has ${this.ground}: drop that file, or choose scenario "elevation model" again`);
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
      const isKept = begun.planners.length === 0;
      this.planner.replaceChildren(...(isKept ? [make("option", { value: "", textContent: "as the scenario says" })] : begun.planners.map((name) => make("option", { value: name, textContent: name }))));
      this.planner.disabled = isKept;
      this.planner.title = isKept ? "Robots of different kinds keep the planners that their scenario names" : "";
      if (begun.planners.includes(chosen)) this.planner.value = chosen;
      this.remember(started.map(({ planner, from }) => ({ planner, from })), hop);
      return null;
    } catch (error) {
      return refuse(error.message);
    }
  }

  /** Shows who is in command. */
  follow({ planner }) {
    if (document.activeElement !== this.planner && [...this.planner.options].some(({ value }) => value === planner)) this.planner.value = planner;
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
    this.groundFor = this.scenario.value;
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
