// A program listing that is added to the page once.  Messages then mark the running line and lines with a breakpoint.
// The lines are grouped in blocks; the browser lays out only the visible blocks of a long listing.
const BLOCK = 100;
const LONG = 300;

export default {
  template: '<div class="listing" role="group"></div>',
  props: { lines: Array, silent: Array, label: String },
  mounted() {
    this.build();
    this.$el.addEventListener("keydown", (event) => this.key(event));
    this.$el.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button) this.$emit("toggle", { line: Number(button.dataset.line) });
    });
  },
  activated() {
    this.$emit("ready"); // the listing was hidden, and has received no updates
  },
  watch: {
    lines() {
      this.build();
    },
  },
  methods: {
    build() {
      const blocks = [];
      const silent = new Set(this.silent);
      this.rows = this.lines.map((text, index) => {
        const row = document.createElement("li");
        const number = document.createElement("button");
        const code = document.createElement("code");
        number.type = "button";
        number.dataset.line = index;
        number.textContent = index + 1;
        number.tabIndex = index === 0 ? 0 : -1;
        number.disabled = silent.has(index);
        number.setAttribute("aria-pressed", "false");
        number.setAttribute("aria-label", `break at line ${index + 1}: ${text}`);
        code.textContent = text;
        row.append(number, code);
        if (index % BLOCK === 0) blocks.push(this.block(index));
        blocks.at(-1).append(row);
        return row;
      });
      this.$el.setAttribute("aria-label", this.label);
      this.$el.replaceChildren(...blocks);
      this.running = null;
      this.$emit("ready");
    },
    block(first) {
      const block = document.createElement("ol");
      block.start = first + 1;
      block.classList.toggle("far", this.lines.length > LONG);
      block.style.height = `${Math.min(this.lines.length - first, BLOCK) * 1.5}em`;
      return block;
    },
    // Marks the line with this index as running; null: no line.  `follow`: scroll to the line.
    run(index, follow) {
      if (this.running) {
        this.running.classList.remove("running");
        this.running.removeAttribute("aria-current");
      }
      this.running = index === null ? null : (this.rows[index] ?? null);
      if (!this.running) return;
      this.running.classList.add("running");
      this.running.setAttribute("aria-current", "step");
      if (follow) this.reveal(index);
    },
    // Marks lines with an enabled breakpoint (`on`) or a disabled one (`off`).
    breaks(on, off) {
      for (const row of this.$el.querySelectorAll(".has-break, .asleep")) this.pin(row, false, false);
      for (const index of on) this.pin(this.rows[index], true, false);
      for (const index of off) this.pin(this.rows[index], true, true);
    },
    pin(row, there, asleep) {
      if (!row) return;
      row.classList.toggle("has-break", there && !asleep);
      row.classList.toggle("asleep", asleep);
      row.firstChild.setAttribute("aria-pressed", String(there));
    },
    height() {
      return parseFloat(getComputedStyle(this.$el).fontSize) * 1.5;
    },
    reveal(index) {
      const box = this.$el;
      const height = this.height();
      const above = index * height - box.scrollTop;
      if (above < 0 || above + height > box.clientHeight) box.scrollTop = index * height - box.clientHeight / 2;
    },
    // Moves the focus to another line number with the arrow keys, Page Up, Page Down, Home and End.
    key(event) {
      const from = event.target.closest("button");
      if (!from) return;
      const last = this.rows.length - 1;
      const page = Math.max(1, Math.floor(this.$el.clientHeight / this.height()) - 1);
      const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -last, End: last };
      if (!(event.key in steps)) return;
      event.preventDefault();
      const way = Math.sign(steps[event.key]);
      let index = Math.min(Math.max(Number(from.dataset.line) + steps[event.key], 0), last);
      while (this.rows[index]?.firstChild.disabled) index += Math.abs(steps[event.key]) === last ? -way : way;
      const to = this.rows[index]?.firstChild;
      if (!to) return;
      from.tabIndex = -1;
      to.tabIndex = 0;
      to.focus({ preventScroll: true });
      this.reveal(index);
    },
  },
};
