// A drawing that is added to the page once.  Messages then change the parts, which have the attribute data-part.
export default {
  template: "<div></div>",
  props: { art: String },
  mounted() {
    this.$el.innerHTML = this.art;
    this.parts = {};
    for (const part of this.$el.querySelectorAll("[data-part]")) this.parts[part.dataset.part] = part;
    const act = (event) => {
      const part = event.target.closest("[data-act]");
      if (!part) return;
      event.preventDefault();
      this.$emit("act", part.dataset.act);
    };
    this.$el.addEventListener("click", act);
    this.$el.addEventListener("keydown", (event) => {
      // the browser itself makes a click of these keys for a button of HTML, but not for a part of an SVG
      if ((event.key === "Enter" || event.key === " ") && !event.repeat && event.target.closest("g[data-act]")) act(event);
    });
    this.$emit("ready");
  },
  activated() {
    this.$emit("ready"); // the drawing was hidden, and has received no updates
  },
  methods: {
    // Applies changes [part, how, value].  `how`: "move" (smooth CSS transform), "jump" (CSS transform at once), "text",
    // ".class" (add or remove the class) or the name of an attribute.
    show(changes) {
      for (const [name, how, value] of changes) {
        const part = this.parts?.[name];
        if (!part) continue;
        if (how === "move" || how === "jump") {
          part.style.transition = how === "jump" ? "none" : "";
          part.style.transform = value;
        } else if (how === "text") part.textContent = value;
        else if (how.startsWith(".")) part.classList.toggle(how.slice(1), value);
        else part.setAttribute(how, value);
      }
    },
  },
};
