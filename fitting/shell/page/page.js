// Photographs go to the page as they are; the bench asks for one picture at a time, always for the newest numbers.
function njSend(token, kind, file) {
  if (!file) return;
  emitEvent("sending", { kind, name: file.name });
  fetch(`/${kind}/${token}?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file })
    .then(async (answer) => {
      const isJson = (answer.headers.get("content-type") || "").includes("json");
      const about = isJson ? await answer.json() : { message: await answer.text() };
      emitEvent(kind, { ok: answer.ok, message: about.message || "" });
    })
    .catch(() => emitEvent(kind, { ok: false, message: "the photograph did not arrive; is it too large?" }));
}
function njDrop(token) {
  // A page that is loaded again finds its photograph by its address.
  history.replaceState(null, "", `?session=${token}`);
  for (const area of document.querySelectorAll(".nj-drop")) {
    const input = area.querySelector("input"), kind = area.dataset.drop;
    input.addEventListener("change", () => njSend(token, kind, input.files[0]));
    for (const name of ["dragenter", "dragover"])
      area.addEventListener(name, (event) => { event.preventDefault(); area.classList.add("over"); });
    for (const name of ["dragleave", "drop"])
      area.addEventListener(name, (event) => { event.preventDefault(); area.classList.remove("over"); });
    area.addEventListener("drop", (event) => njSend(token, kind, event.dataTransfer.files[0]));
  }
}

// A blank opens what has the role of a button, as it presses one, and does not scroll the page.
document.addEventListener("keydown", (event) => {
  if (event.key === " " && event.target.matches('[role="button"], .q-item')) event.preventDefault();
});
// A button that is switched off loses the focus; what takes its place has it then.
function njFocus(id) {
  setTimeout(() => {
    const active = document.activeElement;
    if (active === document.body || active.closest("[disabled]")) document.getElementById(id)?.focus();
  }, 100);
}

// The picture of the bench: the newest numbers are sent as soon as a picture arrives, which is drawn meanwhile.
function njBench(token) {
  const canvas = document.getElementById("bench");
  if (!canvas) return setTimeout(() => njBench(token), 50); // the tab is not there yet
  const line = document.getElementById("bench-line");
  const context = canvas.getContext("2d"), fields = document.querySelectorAll("[data-bench]");
  const socket = new WebSocket(`ws://${location.host}/bench/${token}`);
  socket.binaryType = "arraybuffer";
  let latest = null, isBusy = true, times = [], drawn = Promise.resolve();
  const values = () => {
    const numbers = {};
    for (const field of fields) {
      numbers[field.dataset.bench] = field.type === "range" ? Number(field.value) : field.value;
      if (field.type === "range") document.getElementById(field.id + "-value").textContent = field.value;
    }
    // The lines of a lamp are its own.
    document.getElementById("bench-wavelength").disabled = Boolean(numbers.light);
    return numbers;
  };
  const next = () => {
    isBusy = latest !== null;
    if (isBusy) { socket.send(JSON.stringify(latest)); latest = null; }
  };
  const change = () => { latest = values(); if (!isBusy) next(); };
  socket.onopen = () => { latest = values(); next(); };
  socket.onclose = () => { line.textContent = "The page has ended; load it again."; };
  const draw = async (content) => {
    const picture = await createImageBitmap(new Blob([content], { type: "image/jpeg" }));
    context.drawImage(picture, 0, 0);
    picture.close();
    const now = performance.now();
    times = times.filter((time) => now - time < 1000).concat(now);
    canvas.dataset.drawn = Number(canvas.dataset.drawn || 0) + 1;
    line.textContent = times.length > 2 ? `${times.length} pictures in the last second` : "";
  };
  socket.onmessage = async (event) => {
    if (typeof event.data === "string") { line.textContent = event.data; return next(); }
    await drawn; // no more than one picture waits to be drawn
    next();
    drawn = draw(event.data);
  };
  for (const field of fields) {
    field.addEventListener("input", change);
    field.addEventListener("change", () => emitEvent("bench", values()));
  }
}
