/** The workbench. */
import { Store } from "./store.js";

const store = new Store();
window.workbench = { store };
store.connect();
