"""The process behind the page: cancelled at once, replaced when it dies, and without a trace of its files."""

import asyncio

import pytest

from fitting.shell.page.photograph_tasks import sample
from fitting.shell.page.worker import Worker, WorkError


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of the worker's process alone."""
    return tmp_path_factory.mktemp("worker")


@pytest.fixture(scope="module")
def run(folder):
    """What a coroutine function of a worker returns; one worker for all tests, which loads nothing beforehand."""

    async def begun():
        return Worker(folder)

    with asyncio.Runner() as runner:
        worker = runner.run(begun())
        yield lambda work: runner.run(work(worker))
        worker.close()


async def started(worker, *arguments) -> asyncio.Task:
    """A measurement whose first step is done."""
    event = asyncio.Event()
    task = asyncio.ensure_future(worker.call("measure", *arguments, listener=lambda *_: event.set()))
    task.add_done_callback(lambda _: event.set())  # one that failed before has no step to wait for
    await event.wait()
    return task


def test_one_that_waits_for_its_turn_is_cancelled_without_ending_the_process(run):
    async def work(worker):
        task = asyncio.ensure_future(worker.call("scale", ["0,0", "0,100"], "1mm", ""))
        second = asyncio.ensure_future(worker.call("scale", ["0,0", "0,100"], "1mm", ""))
        await asyncio.sleep(0)
        assert worker.waiting == 2
        process = worker.pid
        second.cancel()
        await task
        assert (worker.pid, worker.waiting) == (process, 0)

    run(work)


def test_what_a_task_raises_is_said_in_one_line_without_the_folder(run, folder):
    async def work(worker):
        with pytest.raises(WorkError) as caught:
            await worker.call("look", b"no picture", "rings.png")
        return str(caught.value)

    message = run(work)
    assert message.startswith("rings.png cannot be read as an image")
    assert str(folder) not in message


def test_cancel_ends_the_process_and_another_one_answers(run, folder):
    async def work(worker):
        task, process = await started(worker, *sample()), worker.pid
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert worker.pid != process
        assert list(folder.iterdir()) == []
        return await worker.call("scale", ["0,0", "0,100"], "1mm", "")

    assert run(work)["pixel_size_m"] == pytest.approx(1e-5)


def test_a_process_that_dies_is_said_and_replaced(run, folder):
    async def work(worker):
        task = await started(worker, *sample())
        worker._process.kill()
        with pytest.raises(WorkError, match="try again"):
            await task
        assert list(folder.iterdir()) == []
        return await worker.call("scale", ["0,0", "0,100"], "1mm", "")

    assert run(work)["pixel_size_m"] == pytest.approx(1e-5)
