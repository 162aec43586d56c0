// A drawing that is added to the page once.  `parts.js` applies the messages that follow.
export default {
  template: "<div></div>",
  props: { art: String },
  mounted() {
    this.parts = window.axistwinParts(this.$el, this.art, (name) => this.$emit("act", name));
    this.$emit("ready");
  },
  activated() {
    this.$emit("ready"); // the drawing was hidden, and has received no updates
  },
  methods: {
    show(changes) {
      this.parts?.show(changes);
    },
  },
};
