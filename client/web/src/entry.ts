// The page's first module: connects to the server, or begins to read files, while the rest of the page is loaded.
import "./style/colors.css";
import "./style/page.css";
import "./style/panel.css";
import "./style/picture.css";
import "./style/bar.css";
import "./style/touch.css";

import { keepStaticAddress, serverAddress } from "./page/server_address";
import { openEarly } from "./stream/channel";

keepStaticAddress();
const isFrame = window.parent !== window; // It connects when it is seen.
try {
  if (!isFrame) openEarly(serverAddress());
} catch {
  // The viewer says why.
}
void import("./main");
