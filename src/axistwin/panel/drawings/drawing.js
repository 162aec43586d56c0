// A drawing that is put on the page once; its parts, named by data-part, are moved, marked and written on.
export default {
  template: "<div></div>",
  props: { art: String },
  mounted() {
    this.$el.innerHTML = this.art;
    this.parts = {};
    for (const part of this.$el.querySelectorAll("[data-part]")) this.parts[part.dataset.part] = part;
    this.$emit("ready");
  },
  activated() {
    this.$emit("ready"); // after it was hidden, and has received no updates
  },
  methods: {
    // Changes: [part, how, value]; how: "move" to a transform smoothly, "jump" there, "text", ".class" or an attribute.
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
