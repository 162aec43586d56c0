// The list of a conversation; `log.js` adds the messages that follow.
export default {
  template: "<div></div>",
  mounted() {
    this.log = window.axistwinLog(this.$el, (text) => this.$emit("keys", text));
    this.$emit("ready");
  },
  activated() {
    this.$emit("ready"); // the list was hidden, and has received no updates
  },
  methods: {
    add(entries) {
      this.log?.add(entries);
    },
    clear() {
      this.log?.clear();
    },
  },
};
