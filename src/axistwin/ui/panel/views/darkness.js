// Sets dark or light colours.  NiceGUI's own element also sets them again at each update of the page, and the browser then
// calculates all styles of the page again.
export default {
  props: { value: Boolean },
  mounted() {
    setDark(this.value);
  },
  watch: {
    value(value) {
      setDark(value);
    },
  },
};
