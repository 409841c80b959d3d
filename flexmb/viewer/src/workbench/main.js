/** The workbench. */
import { Canvas } from "./canvas.js";
import { Store } from "./store.js";

const store = new Store();
const [scene, overlay] = ["scene", "overlay"].map((id) => document.getElementById(id));
window.workbench = { store, canvas: new Canvas({ scene, overlay, store }) };
store.connect();
