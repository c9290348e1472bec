// Photographs go to the page as they are; the bench asks for one picture at a time, always for the newest numbers.
function njSend(token, file) {
  if (!file) return;
  emitEvent("sending", { name: file.name });
  fetch(`/photograph/${token}?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file })
    .then(async (answer) => {
      const isJson = (answer.headers.get("content-type") || "").includes("json");
      const about = isJson ? await answer.json() : { message: await answer.text() };
      emitEvent("photograph", { ok: answer.ok, message: about.message || "" });
    })
    .catch(() => emitEvent("photograph", { ok: false, message: "the photograph did not arrive; is it too large?" }));
}
function njDrop(token) {
  const area = document.querySelector(".nj-drop");
  const input = area.querySelector("input");
  input.addEventListener("change", () => njSend(token, input.files[0]));
  for (const kind of ["dragenter", "dragover"])
    area.addEventListener(kind, (event) => { event.preventDefault(); area.classList.add("over"); });
  for (const kind of ["dragleave", "drop"])
    area.addEventListener(kind, (event) => { event.preventDefault(); area.classList.remove("over"); });
  area.addEventListener("drop", (event) => njSend(token, event.dataTransfer.files[0]));
}
