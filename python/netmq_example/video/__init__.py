"""Films of the views of a running game. All but the game's side need numpy and Pillow."""

from typing import TYPE_CHECKING

from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.video.film_writer import Film, open_film
    from netmq_example.video.films import Films
    from netmq_example.video.view_film import ViewFilm
    from netmq_example.video.view_sender import FilmView, ViewSender

__all__ = ["Film", "FilmView", "Films", "ViewFilm", "ViewSender", "open_film"]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {
        "film_writer": "Film open_film",
        "films": "Films",
        "view_film": "ViewFilm",
        "view_sender": "FilmView ViewSender",
    }
    __getattr__, __dir__ = door(__name__, ROOMS)
