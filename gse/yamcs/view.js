// SPDX-License-Identifier: Apache-2.0
// The page of the light station within the page of Yamcs, which creates this element at
// /telemetry/ext/hirosco-view. run.py sets the address.

class View extends HTMLElement {
  connectedCallback() {
    const frame = document.createElement("iframe");
    frame.src = "@STATION@";
    frame.title = "3D view and joystick";
    frame.style = "border:0;width:100%;height:calc(100vh - 120px)";
    const words = document.createElement("p");
    words.style = "margin:4px 16px";
    words.textContent = "This view shows the page of make gse, which must be running: @STATION@";
    this.replaceChildren(words, frame);
  }
}

customElements.define("hirosco-view", View);
